#include "app/reports/comparison_page.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "app/files/tum.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::reports {
namespace {

/// Ten metres along x; the estimate is in a frame of its own.
class ComparisonPageTest : public testing::Test {
 protected:
  ComparisonPageTest() {
    std::vector<StampedPose> truth;
    std::vector<StampedPose> estimate;
    for (int i = 0; i <= 10; ++i) {
      const Pose2 T_truth_base{1.0 * i, 0, 0.1};
      truth.push_back(ToStampedPose(i, T_truth_base));
      estimate.push_back(ToStampedPose(i, kTEstimateTruth * T_truth_base));
    }
    folder_.Write("truth.tum", files::FormatTum(truth));
    folder_.Write("run.tum", files::FormatTum(estimate));
    params_.truth = folder_ / "truth.tum";
    params_.estimates = {(folder_ / "run.tum").string()};
  }

  // Status lines of the same run, with a smaller standard deviation along x of its own frame.
  void WriteStatus() {
    std::string text =
        "timestamp,status,x,y,yaw_deg,pitch_deg,roll_deg,sigma_x,sigma_y,sigma_yaw_deg\n";
    for (const StampedPose& pose : files::ReadTum(folder_ / "run.tum")) {
      text += std::to_string(pose.stamp_s) + ",tracking," + std::to_string(pose.position.x()) +
              "," + std::to_string(pose.position.y()) + "," +
              std::to_string(YawOf(pose) * 180 / std::numbers::pi) + ",0,0,0.001,0.002,0.1\n";
    }
    folder_.Write("run.csv", text);
    params_.estimates = {(folder_ / "run.csv").string()};
  }

  const Pose2 kTEstimateTruth{5, -3, std::numbers::pi / 2};
  support::TestFolder folder_;
  ComparisonInputs params_;
};

TEST_F(ComparisonPageTest, RunsLieOnTheTruthInEitherFrame) {
  const Comparison comparison = Compare(params_);
  for (const ShownFrame frame : {ShownFrame::kTruth, ShownFrame::kFirstRun}) {
    const page::PageData data = ComparisonPage(comparison, {}, frame, "m");
    data.Validate();
    ASSERT_EQ(data.paths.size(), 2U);
    EXPECT_EQ(data.paths[0].role, page::PathRole::kTruth);
    EXPECT_EQ(data.paths[1].name, "run");
    const Pose2 last =
        frame == ShownFrame::kTruth ? Pose2{10, 0, 0.1} : kTEstimateTruth * Pose2{10, 0, 0.1};
    for (const page::PagePath& path : data.paths) {
      ASSERT_EQ(path.poses.size(), 11U);
      EXPECT_NEAR(path.poses.back().x, last.x, 1e-6);
      EXPECT_NEAR(path.poses.back().y, last.y, 1e-6);
      EXPECT_NEAR(
          std::remainder(path.poses.back().yaw_rad - last.yaw, 2 * std::numbers::pi), 0, 1e-6);
      EXPECT_EQ(path.poses.back().stamp_s, 10);
    }
  }
}

TEST_F(ComparisonPageTest, ThePageMayHaveAnotherFrameThanTheRun) {
  const Similarity2 S_page_run{{100, 200, -std::numbers::pi / 2}, 3};
  const page::PageData data =
      ComparisonPage(Compare(params_), {}, ShownFrame::kFirstRun, "m", S_page_run);
  const Pose2 last = S_page_run * (kTEstimateTruth * Pose2{10, 0, 0.1});
  for (const page::PagePath& path : data.paths) {
    EXPECT_NEAR(path.poses.back().x, last.x, 1e-6);
    EXPECT_NEAR(path.poses.back().y, last.y, 1e-6);
    EXPECT_NEAR(
        std::remainder(path.poses.back().yaw_rad - last.yaw, 2 * std::numbers::pi), 0, 1e-6);
  }
}

TEST_F(ComparisonPageTest, CovariancesTurnWithTheFrame) {
  WriteStatus();
  const Comparison comparison = Compare(params_);
  const auto covariance = [&comparison](ShownFrame frame) {
    return ComparisonPage(comparison, {}, frame, "m").paths[1].poses[5].covariance;
  };
  const std::array<double, 4> own = covariance(ShownFrame::kFirstRun);
  EXPECT_NEAR(own[0], 1e-6, 1e-9);
  EXPECT_NEAR(own[2], 4e-6, 1e-9);
  EXPECT_NEAR(own[3], std::pow(0.1 * std::numbers::pi / 180, 2), 1e-9);
  const std::array<double, 4> turned = covariance(ShownFrame::kTruth);
  EXPECT_NEAR(turned[0], 4e-6, 1e-9);
  EXPECT_NEAR(turned[1], 0, 1e-9);
  EXPECT_NEAR(turned[2], 1e-6, 1e-9);
}

TEST_F(ComparisonPageTest, FramesThatWereNotPlacedAreBetweenThePoses) {
  WriteStatus();
  std::string text = support::ReadAll(folder_ / "run.csv");
  text.insert(text.find("\n4.") + 1,
              "3.500000,ambiguous,,,,,,,,\n3.7,of another program,,,,,,,,\n");
  folder_.Write("run.csv", text);
  const page::PageData data = ComparisonPage(Compare(params_), {}, ShownFrame::kTruth, "m");
  data.Validate();
  const std::vector<page::PagePose>& poses = data.paths[1].poses;
  ASSERT_EQ(poses.size(), 13U);
  EXPECT_EQ(poses[3].status, graph::TrackingStatus::kTracking);
  EXPECT_EQ(poses[4].status, graph::TrackingStatus::kAmbiguous);
  EXPECT_EQ(poses[4].stamp_s, 3.5);
  EXPECT_TRUE(std::isnan(poses[4].x));
  EXPECT_EQ(poses[5].status, graph::TrackingStatus::kLost);
  EXPECT_NEAR(poses[6].x, 4, 1e-6);
}

TEST_F(ComparisonPageTest, ShowsWhatCompensationIsWorth) {
  params_.before = folder_ / "run.tum";
  const page::PageData data = ComparisonPage(Compare(params_), {}, ShownFrame::kTruth, "m");
  ASSERT_EQ(data.paths.size(), 3U);
  EXPECT_EQ(data.paths[1].role, page::PathRole::kBefore);
  EXPECT_NEAR(data.paths[1].poses[7].x, 7, 1e-6);
  data.Validate();
  ASSERT_EQ(data.charts.size(), 5U);
  EXPECT_EQ(data.charts[4].series.at(0).name, data.paths[1].name);
  EXPECT_NEAR(data.charts[4].series[0].y.at(7), 0, 1e-3);
}

TEST_F(ComparisonPageTest, NamesOfRunsStayTheirOwn) {
  params_.estimates = {"truth=" + (folder_ / "run.tum").string()};
  const page::PageData data = ComparisonPage(Compare(params_), {}, ShownFrame::kTruth, "m");
  EXPECT_EQ(data.paths[0].name, "truth*");
  EXPECT_EQ(data.paths[1].name, "truth");
}

TEST_F(ComparisonPageTest, HeadingsAloneTurnTheRobotWhereItTrulyWas) {
  folder_.Write("h.csv", "timestamp,heading_deg\n0,0\n5,1\n10,0.5\n");
  params_.estimates = {(folder_ / "h.csv").string()};
  const page::PageData data = ComparisonPage(Compare(params_), {}, ShownFrame::kTruth, "m");
  data.Validate();
  ASSERT_EQ(data.paths.size(), 2U);  // true positions, with the yaw of the compass
  EXPECT_EQ(data.paths[1].name, "h (heading)");
  EXPECT_NEAR(data.paths[1].poses.at(1).x, 5, 1e-6);
  EXPECT_NEAR(data.paths[1].poses[1].yaw_rad, 0.1 + std::numbers::pi / 180, 1e-6);
  ASSERT_EQ(data.charts.size(), 1U);
  EXPECT_EQ(data.charts[0].series.at(0).name, "h (heading)");
  EXPECT_NEAR(data.charts[0].series[0].y[1], 1, 1e-9);
}

}  // namespace
}  // namespace ceilmap::reports
