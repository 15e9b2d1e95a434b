#include "app/files/status_csv.hpp"

#include <numbers>

#include "tests/support/test_folder.hpp"

namespace ceilmap::files {
namespace {

using graph::TrackingStatus;

TEST(StatusCsv, APlacedFrame) {
  robot::Estimate estimate;
  estimate.status = TrackingStatus::kRelocalized;
  estimate.stamp_s = 12.5;
  estimate.pose.pose = {1, -2.25, std::acos(-1.0) / 4};
  estimate.pose.covariance.diagonal() << 1e-6, 4e-6, 1e-8;
  estimate.peak = 0.71;
  estimate.inliers = 40;
  EXPECT_EQ(FormatStatusLine(estimate),
            "12.500000,relocalized,1.000000,-2.250000,45.00000,0,0,0.001000,0.002000,0.00573,0.710,"
            "40\n");
}

TEST(StatusCsv, AFrameWithoutAPoseHasNoNumbersAndAsManyFields) {
  robot::Estimate estimate;
  estimate.stamp_s = 3;
  const std::string_view header = StatusHeader();
  for (const TrackingStatus status : {TrackingStatus::kLost, TrackingStatus::kAmbiguous}) {
    estimate.status = status;
    estimate.pose.pose = {1, 2, 3};
    const std::string line = FormatStatusLine(estimate);
    EXPECT_EQ(line, std::string("3.000000,") + graph::ToString(status) + ",,,,,,,,,,\n");
    EXPECT_EQ(std::count(line.begin(), line.end(), ','),
              std::count(header.begin(), header.end(), ','));
  }
}

TEST(StatusCsv, APredictedFrameHasNumbersButIsNotPlaced) {
  const support::TestFolder folder;
  robot::Estimate predicted;
  predicted.status = TrackingStatus::kPredicted;
  predicted.stamp_s = 12.5;
  predicted.pose.pose = {1, -2.25, 0};
  predicted.pose.covariance.diagonal() << 1e-2, 4e-2, 1e-2;
  const std::string line = FormatStatusLine(predicted);
  EXPECT_EQ(line,
            "12.500000,predicted,1.000000,-2.250000,0.00000,0,0,0.100000,0.200000,5.72958,0.000,"
            "0\n");
  const StatusRecord record = ReadStatus(folder.Write("s.csv", std::string(StatusHeader()) + line));
  EXPECT_TRUE(record.poses.empty());
  ASSERT_EQ(record.unplaced.size(), 1U);
  EXPECT_EQ(record.unplaced[0].status, TrackingStatus::kPredicted);
  EXPECT_EQ(record.frames, (std::map<std::string, std::int64_t>{{"predicted", 1}}));
}

TEST(StatusCsv, IsReadBack) {
  const support::TestFolder folder;
  robot::Estimate placed;
  placed.status = TrackingStatus::kTracking;
  placed.stamp_s = 12.5;
  placed.pose.pose = {1, -2.25, 0.75};
  placed.tilt.pitch_rad = 0.1;
  placed.pose.covariance.diagonal() << 1e-6, 4e-6, 1e-4;
  robot::Estimate lost;
  lost.status = TrackingStatus::kLost;
  lost.stamp_s = 13;
  const StatusRecord record = ReadStatus(folder.Write(
      "s.csv", std::string(StatusHeader()) + FormatStatusLine(placed) + FormatStatusLine(lost)));
  ASSERT_EQ(record.poses.size(), 1U);
  EXPECT_EQ(record.poses[0].stamp_s, 12.5);
  EXPECT_NEAR((record.poses[0].position - Eigen::Vector3d(1, -2.25, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR(YawOf(record.poses[0]), 0.75, 1e-6);
  EXPECT_NEAR(PitchOf(record.poses[0]), 0.1, 1e-6);
  ASSERT_EQ(record.covariances.size(), 1U);
  EXPECT_NEAR(record.covariances[0](1, 1), 4e-6, 1e-9);
  EXPECT_NEAR(record.covariances[0](2, 2), 1e-4, 1e-6);
  EXPECT_EQ(record.covariances[0](0, 1), 0);
  EXPECT_EQ(record.frames, (std::map<std::string, std::int64_t>{{"lost", 1}, {"tracking", 1}}));
}

TEST(StatusCsv, FaultsAreNamed) {
  const support::TestFolder folder;
  const std::string header(StatusHeader());
  const auto expect = [&](const std::string& text, const std::vector<std::string>& parts) {
    SCOPED_TRACE(text);
    support::ExpectInputError([&] { ReadStatus(folder.Write("s.csv", text)); }, parts);
  };
  expect("timestamp,status\n", {"s.csv:1", "'x'"});
  expect(header + "1,lost,,,,,,,,,,\n1,lost,,,,,,,,,,\n", {"s.csv:3", "not later"});
  expect(header + "1,tracking,1,,0,0,0,1,1,1,1,9\n", {"s.csv:2", "y ''"});
  expect(header + "1,tracking,1,nan,0,0,0,1,1,1,1,9\n", {"s.csv:2", "y 'nan'"});
  expect(header + "1,tracking,1,2,0,0,0,1,-1,1,1,9\n", {"s.csv:2", "negative"});
}

}  // namespace
}  // namespace ceilmap::files
