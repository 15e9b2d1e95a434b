#include "app/reports/comparison_figures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::reports {
namespace {

/// Three rounds of a circle.
std::vector<StampedPose> Circle() {
  std::vector<StampedPose> poses;
  for (int i = 0; i < 200; ++i) {
    const double a = 0.1 * i;
    poses.push_back(ToStampedPose(
        50 + 0.1 * i, {2 * std::cos(a), 2 * std::sin(a), WrapAngle(a + std::numbers::pi / 2)}));
  }
  return poses;
}

std::vector<StampedPose> Moved(const std::vector<StampedPose>& poses, const Pose2& T) {
  std::vector<StampedPose> moved;
  for (const StampedPose& pose : poses) {
    moved.push_back(ToStampedPose(pose.stamp_s, T * PlanarPose(pose)));
  }
  return moved;
}

TEST(ComparisonFigures, TurnsGoOnBeyondAHalf) {
  const std::vector<figures::FigurePose> poses = FigurePoses(Circle());
  EXPECT_NEAR(poses.back().yaw_deg - poses.front().yaw_deg, 19.9 * 180 / std::numbers::pi, 1e-9);
  EXPECT_EQ(poses.front().time_s, 0);
  EXPECT_NEAR(poses.back().distance_m, 199 * 4 * std::sin(0.05), 1e-9);
}

TEST(ComparisonFigures, AreInTheFrameOfTheTruthOrOfTheFirstRun) {
  const std::vector<StampedPose> truth = Circle();
  const std::vector<StampedPose> first = Moved(truth, {3, -1, 0.7});
  const std::vector<StampedPose> second = Moved(truth, {8, 2, -2});
  const auto errors = evaluation::EvaluateTrajectory(truth, first);
  const auto others = evaluation::EvaluateTrajectory(truth, second);
  const std::vector<ComparedRun> runs = {{"first", &*errors}, {"second", &*others}};
  for (const ShownFrame frame : {ShownFrame::kTruth, ShownFrame::kFirstRun}) {
    const figures::TrajectoryComparison comparison =
        ComparisonFor(truth, runs, T_shown_truth(runs, frame));
    const std::vector<figures::FigurePose> expected =
        FigurePoses(frame == ShownFrame::kTruth ? truth : first);
    ASSERT_EQ(comparison.runs.size(), 2U);
    for (const std::vector<figures::FigurePose>* shown :
         {&comparison.truth, &comparison.runs[0].poses, &comparison.runs[1].poses}) {
      ASSERT_EQ(shown->size(), expected.size());
      for (std::size_t i = 0; i < expected.size(); ++i) {
        ASSERT_NEAR((*shown)[i].x, expected[i].x, 1e-9) << i;
        ASSERT_NEAR((*shown)[i].y, expected[i].y, 1e-9) << i;
        ASSERT_NEAR(std::remainder((*shown)[i].yaw_deg - expected[i].yaw_deg, 360), 0, 1e-7) << i;
        ASSERT_NEAR((*shown)[i].position_error_m, 0, 1e-9) << i;
      }
    }
  }
}

TEST(ComparisonFigures, OfAMapInAnotherScaleFitThatMap) {
  const std::vector<StampedPose> truth = Circle();
  std::vector<StampedPose> estimate = Moved(truth, {1, 2, 0.4});
  for (StampedPose& pose : estimate) pose.position *= 100;  // in pixels
  const auto errors =
      evaluation::EvaluateTrajectory(truth, estimate, {.align = evaluation::Alignment::kSim2});
  const std::vector<ComparedRun> runs = {{"pixels", &*errors}};
  const figures::TrajectoryComparison comparison =
      ComparisonFor(truth, runs, T_shown_truth(runs, ShownFrame::kFirstRun));
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    ASSERT_NEAR(comparison.runs[0].poses[i].x, estimate[i].position.x(), 1e-6) << i;
    ASSERT_NEAR(comparison.truth[i].y, estimate[i].position.y(), 1e-6) << i;
  }
}

TEST(ComparisonFigures, CarryTheErrorsOfEachFrame) {
  const std::vector<StampedPose> truth = Circle();
  std::vector<StampedPose> estimate = truth;
  const Pose2 off = PlanarPose(truth[7]);
  estimate[7] = ToStampedPose(truth[7].stamp_s, {off.x + 0.3, off.y, off.yaw + 0.1});
  const auto errors =
      evaluation::EvaluateTrajectory(truth, estimate, {.align = evaluation::Alignment::kNone});
  const figures::FigurePose pose = ComparisonFor(truth, {{"run", &*errors}}, {}).runs[0].poses[7];
  EXPECT_NEAR(pose.position_error_m, 0.3, 1e-9);
  EXPECT_NEAR(pose.yaw_error_deg, 0.1 * 180 / std::numbers::pi, 1e-9);
}

TEST(ComparisonFigures, TheMosaicLiesWhereTheMapHasIt) {
  const support::TestFolder folder;
  store::synthetic::SmallMap().Write(folder / "map.gpkg");
  const store::MapReader map(folder / "map.gpkg");
  const auto mosaic = WriteMosaic(map, folder.Path());
  ASSERT_TRUE(mosaic);
  const store::MosaicGrid& grid = map.Grid();
  const cv::Mat image = cv::imread((folder / mosaic->file).string(), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(image.size(), cv::Size(grid.width_px, grid.height_px));
  EXPECT_EQ(mosaic->min_x, grid.min_x);
  EXPECT_DOUBLE_EQ(mosaic->min_y + grid.height_px * mosaic->metres_per_px, grid.max_y);
  EXPECT_EQ(image.at<std::uint8_t>(0, 0), 255) << "unmapped";
}

}  // namespace
}  // namespace ceilmap::reports
