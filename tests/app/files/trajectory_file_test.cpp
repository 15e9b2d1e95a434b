#include "app/files/trajectory_file.hpp"

#include <numbers>

#include "app/bags/bag_reader.hpp"
#include "app/bags/message_types.hpp"
#include "app/bags/result_messages.hpp"
#include "app/files/estimate_file.hpp"
#include "app/files/tum.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::files {
namespace {

using bags::MessageEncoding;
using graph::TrackingStatus;
using Level = bags::DiagnosticsMessage::Level;

robot::Estimate AtTime(double stamp_s, TrackingStatus status) {
  robot::Estimate estimate;
  estimate.stamp_s = stamp_s;
  estimate.status = status;
  estimate.pose.pose = {1, -2.25, std::numbers::pi / 2};
  estimate.pose.covariance << 1, 2, 3, 2, 5, 6, 3, 6, 10;
  estimate.tilt.pitch_rad = 0.02;
  estimate.tilt.roll_rad = -0.01;
  estimate.tilt.lift_m = 0.003;
  estimate.tilt.covariance << 4e-4, 1e-4, 1e-4, 9e-4;
  estimate.peak = 0.71;
  estimate.inliers = 40;
  estimate.blocks = 48;
  return estimate;
}

const std::vector<TrackingStatus> kStatuses = {TrackingStatus::kTracking,
                                               TrackingStatus::kRelocalized,
                                               TrackingStatus::kPredicted,
                                               TrackingStatus::kAmbiguous,
                                               TrackingStatus::kLost};

// A frame of each status, at 10, 11, ... s.
void WriteEachStatus(TrajectoryFile& file, const std::vector<bool>& expected) {
  for (std::size_t i = 0; i < kStatuses.size(); ++i) {
    EXPECT_EQ(file.Add(AtTime(10.0 + static_cast<double>(i), kStatuses[i])), expected[i]) << i;
  }
  file.Commit();
}

TEST(TrajectoryFile, TextHasFramesWithAPose) {
  const support::TestFolder folder;
  TrajectoryFile file(folder / "t.tum");
  EXPECT_FALSE(file.IsBag());
  WriteEachStatus(file, {true, true, false, false, false});
  const auto poses = ReadTum(folder / "t.tum");
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[1].stamp_s, 11);
  TrajectoryFile predicted(folder / "p.tum", true);
  WriteEachStatus(predicted, {true, true, true, false, false});
  EXPECT_EQ(ReadTum(folder / "p.tum").size(), 3U);
}

TEST(TrajectoryFile, TextAndBagHoldTheSamePoses) {
  const support::TestFolder folder;
  for (const bool predicted : {false, true}) {
    TrajectoryFile text(folder / "t.tum", predicted);
    TrajectoryFile bag(folder / "t.mcap", predicted);
    WriteEachStatus(text, {true, true, predicted, false, false});
    WriteEachStatus(bag, {true, true, predicted, false, false});
    const Estimate by_text = ReadEstimate(folder / "t.tum");
    const Estimate by_bag = ReadEstimate(folder / "t.mcap");
    ASSERT_EQ(by_bag.poses.size(), by_text.poses.size());
    for (std::size_t i = 0; i < by_bag.poses.size(); ++i) {
      EXPECT_EQ(by_bag.poses[i].stamp_s, by_text.poses[i].stamp_s);
      EXPECT_LT((by_bag.poses[i].position - by_text.poses[i].position).norm(), 1e-9);
      EXPECT_LT(by_bag.poses[i].orientation.angularDistance(by_text.poses[i].orientation), 1e-9);
    }
    EXPECT_EQ(
        by_bag.frames_of_status,
        (std::map<std::string, std::int64_t>{
            {"tracking", 1}, {"relocalized", 1}, {"predicted", 1}, {"ambiguous", 1}, {"lost", 1}}));
    EXPECT_EQ(by_bag.unplaced.size(), predicted ? 2U : 3U);
    EXPECT_EQ(by_bag.unplaced.back().status, TrackingStatus::kLost);
    ASSERT_TRUE(by_bag.covariances.at(0));
    EXPECT_EQ(*by_bag.covariances[0], AtTime(0, kStatuses[0]).pose.covariance);
  }
}

TEST(TrajectoryFile, CovariancesAreAboutTheAxesOfTheMap) {
  const support::TestFolder folder;
  TrajectoryFile file(folder / "t.mcap");
  file.Add(AtTime(10, TrackingStatus::kTracking));
  file.Commit();
  const auto bag = bags::BagReader::Open(folder / "t.mcap");
  for (bags::RawMessage message; bag->Next(message);) {
    if (bag->Topics()[message.topic].type != bags::kPoseType) continue;
    EXPECT_EQ(message.log_time_ns, 10'000'000'000);
    const auto covariance = bags::DecodePose(message.data, MessageEncoding::kCdr).covariance;
    // The robot looks along the map's y: its roll is about y, its pitch about -x.
    const std::array<double, 36> expected = {1, 2, 0, 0,     0,     3,  //
                                             2, 5, 0, 0,     0,     6,  //
                                             0, 0, 0, 0,     0,     0,  //
                                             0, 0, 0, 4e-4,  -1e-4, 0,  //
                                             0, 0, 0, -1e-4, 9e-4,  0,  //
                                             3, 6, 0, 0,     0,     10};
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_NEAR(covariance.at(i), expected.at(i), 1e-15) << i;
    }
    return;
  }
  FAIL() << "no pose";
}

TEST(TrajectoryFile, DiagnosticsHaveTheStatusAndItsValues) {
  const support::TestFolder folder;
  TrajectoryFile file(folder / "t.mcap");
  WriteEachStatus(file, {true, true, false, false, false});
  const auto bag = bags::BagReader::Open(folder / "t.mcap");
  std::vector<bags::DiagnosticsMessage> messages;
  for (bags::RawMessage message; bag->Next(message);) {
    if (bag->Topics()[message.topic].type != bags::kDiagnosticsType) continue;
    messages.push_back(bags::DecodeDiagnostics(message.data, MessageEncoding::kCdr));
  }
  const std::vector<Level> levels = {
      Level::kOk, Level::kWarn, Level::kWarn, Level::kWarn, Level::kError};
  ASSERT_EQ(messages.size(), levels.size());
  using Values = std::vector<std::pair<std::string, std::string>>;
  const Values agreement = {
      {"peak", "0.710"}, {"inliers", "40"}, {"blocks", "48"}, {"hypotheses", "0"}};
  Values all = agreement;
  for (const auto& value : Values{{"sigma_x", "1.000000"},
                                  {"sigma_y", "2.236068"},
                                  {"sigma_yaw_deg", "181.18516"},
                                  {"pitch_deg", "1.14592"},
                                  {"roll_deg", "-0.57296"}}) {
    all.push_back(value);
  }
  for (std::size_t i = 0; i < levels.size(); ++i) {
    ASSERT_EQ(messages[i].status.size(), 1U);
    const auto& status = messages[i].status[0];
    EXPECT_EQ(status.level, levels[i]);
    EXPECT_EQ(status.name, "ceilmap");
    EXPECT_EQ(status.hardware_id, "up");
    EXPECT_EQ(status.message, graph::ToString(kStatuses[i]));
    EXPECT_EQ(status.values, i < 3 ? all : agreement);
  }
}

TEST(TrajectoryFile, IsAbsentUntilCommit) {
  const support::TestFolder folder;
  for (const char* name : {"t.tum", "t.mcap"}) {
    TrajectoryFile file(folder / name);
    file.Add(AtTime(10, TrackingStatus::kTracking));
    file.Close();
    EXPECT_FALSE(std::filesystem::exists(folder / name));
  }
  EXPECT_EQ(support::NamesIn(folder.Path()), std::vector<std::string>{});
}

}  // namespace
}  // namespace ceilmap::files
