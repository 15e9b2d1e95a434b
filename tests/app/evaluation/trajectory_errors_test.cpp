#include "app/evaluation/trajectory_errors.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ceilmap::evaluation {
namespace {

std::vector<StampedPose> Poses(const std::vector<Pose2>& planar, double first_s = 0) {
  std::vector<StampedPose> poses;
  poses.reserve(planar.size());
  for (const Pose2& pose : planar) {
    poses.push_back(ToStampedPose(first_s + static_cast<double>(poses.size()), pose));
  }
  return poses;
}

TEST(EvaluateTrajectory, AlignmentTakesARigidMotionOut) {
  const std::vector<Pose2> path = {{0, 0, 0}, {1, 0, 0.3}, {1, 2, 1}, {-1, 2, -2.5}};
  const Pose2 T{3, -4, 2.9};
  std::vector<Pose2> moved;
  moved.reserve(path.size());
  for (const Pose2& pose : path) moved.push_back(T * pose);
  for (const Alignment align : {Alignment::kSe2, Alignment::kFirst}) {
    const auto errors = EvaluateTrajectory(Poses(path), Poses(moved), {.align = align});
    ASSERT_TRUE(errors);
    EXPECT_LT(errors->position_m.max, 1e-14);
    EXPECT_LT(errors->yaw_deg.max, 1e-12);
    EXPECT_EQ(errors->matched, 4);
    EXPECT_EQ(errors->Coverage(), 1);
    EXPECT_DOUBLE_EQ(errors->path_m, 5);
  }
}

TEST(EvaluateTrajectory, WithoutAlignmentTheOffsetCounts) {
  const auto errors = EvaluateTrajectory(Poses({{0, 0, 0}, {0.5, 0, 0}}),
                                         Poses({{3, 4, 0.1}, {3.5, 4, 0.1}}),
                                         {.align = Alignment::kNone});
  ASSERT_TRUE(errors);
  EXPECT_DOUBLE_EQ(errors->position_m.rmse, 5);
  EXPECT_NEAR(errors->yaw_deg.mean, 0.1 * kDegPerRad, 1e-12);
  EXPECT_FALSE(errors->per_metre_m);  // the path is shorter than a metre
}

TEST(EvaluateTrajectory, Se2FitSplitsTheErrorByLeastSquares) {
  // Four corners of a square, the estimate one of them 0.4 m off along x: the mean takes 0.1 of it,
  // the rotation atan2(cross, dot) = atan2(-0.4, 8.4) about the centre.
  const std::vector<Pose2> square = {{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}};
  std::vector<Pose2> off = square;
  off[0].x += 0.4;
  const auto errors = EvaluateTrajectory(Poses(square), Poses(off));
  ASSERT_TRUE(errors);
  const double turn = std::atan2(0.4, 8.4);
  EXPECT_NEAR(errors->yaw_deg.max, turn * kDegPerRad, 1e-12);
  // |R q - p|^2 summed = |q|^2 + |p|^2 - 2 hypot(dot, cross), all about their means.
  const double squares = (8 + 0.4 * 2 + 0.16 - 4 * 0.01) + 8 - 2 * std::hypot(8.4, 0.4);
  EXPECT_NEAR(errors->position_m.rmse, std::sqrt(squares / 4), 1e-12);
}

TEST(EvaluateTrajectory, RelativeErrorPerMetre) {
  // Half-metre steps straight on; the estimate is 2 % long and turns by 0.01 rad a step.
  std::vector<Pose2> truth;
  std::vector<Pose2> estimate;
  for (int i = 0; i < 5; ++i) {
    truth.push_back({0.5 * i, 0, 0});
    estimate.push_back({0.51 * i, 0, 0.01 * i});
  }
  const auto errors = EvaluateTrajectory(Poses(truth), Poses(estimate));
  ASSERT_TRUE(errors && errors->per_metre_m);
  EXPECT_NEAR(errors->per_metre_yaw_deg->max, 0.02 * kDegPerRad, 1e-12);
  EXPECT_NEAR(errors->per_metre_yaw_deg->rmse, 0.02 * kDegPerRad, 1e-12);
  // From the last start, whose yaw is 0.02: (1.02 cos, -1.02 sin) against (1, 0).
  EXPECT_NEAR(errors->per_metre_m->max,
              std::hypot(1.02 * std::cos(0.02) - 1, 1.02 * std::sin(0.02)),
              1e-12);
}

TEST(EvaluateTrajectory, InAFrameThatIsKnown) {
  // The map's frame is 10 m further on; the robot is 0.25 m off on the map, which counts.
  const std::vector<Pose2> path = {{0, 0, 0}, {1, 0, 0}};
  const auto errors = EvaluateTrajectory(Poses(path),
                                         Poses({{10.25, 0, 0}, {11.25, 0, 0}}),
                                         {.T_truth_estimate = Similarity2{{-10, 0, 0}, 1}});
  ASSERT_TRUE(errors);
  EXPECT_DOUBLE_EQ(errors->position_m.mean, 0.25);
  EXPECT_DOUBLE_EQ(errors->T_truth_estimate.motion.x, -10);
}

TEST(EvaluateTrajectory, Sim2TakesAScaleOutToo) {
  const std::vector<Pose2> path = {{0, 0, 0}, {1, 0, 0.3}, {1, 2, 1}, {-1, 2, -2.5}};
  std::vector<Pose2> pixels;
  for (const Pose2& pose : path) pixels.push_back({200 * pose.x + 7, 200 * pose.y, pose.yaw});
  const auto errors = EvaluateTrajectory(Poses(path), Poses(pixels), {.align = Alignment::kSim2});
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->T_truth_estimate.scale, 0.005, 1e-15);
  EXPECT_LT(errors->position_m.max, 1e-12);
  EXPECT_LT(errors->per_metre_m->max, 1e-12);  // in metres of the truth
  EXPECT_LT(errors->per_frame->translation_m.max, 1e-12);
}

TEST(EvaluateTrajectory, ReportsEachFrame) {
  // Up along y; the last pose is half a metre ahead of the true one and 0.1 m left of it.
  const double up = std::numbers::pi / 2;
  const auto errors = EvaluateTrajectory(Poses({{0, 0, up}, {0, 1, up}, {0, 3, up}}, 10),
                                         Poses({{0, 1, up}, {-0.1, 3.5, up + 0.1}}, 11),
                                         {.align = Alignment::kNone});
  ASSERT_TRUE(errors);
  ASSERT_EQ(errors->frames.size(), 2U);
  const FrameError& frame = errors->frames[1];
  EXPECT_EQ(frame.truth, 2U);
  EXPECT_EQ(frame.estimate, 1U);
  EXPECT_EQ(frame.stamp_s, 12);
  EXPECT_DOUBLE_EQ(frame.distance_m, 3);
  EXPECT_NEAR(frame.along_m, 0.5, 1e-14);
  EXPECT_NEAR(frame.across_m, 0.1, 1e-14);
  EXPECT_NEAR(frame.position_m, std::hypot(0.5, 0.1), 1e-14);
  EXPECT_NEAR(frame.yaw_deg, 0.1 * kDegPerRad, 1e-12);
  EXPECT_NEAR(frame.pose.angle_rad, 0.1, 1e-14);
  EXPECT_NEAR(frame.T_truth_base.y, 3.5, 1e-14);
  EXPECT_FALSE(errors->tilted);
}

TEST(EvaluateTrajectory, InSpaceHeightAndTiltCount) {
  std::vector<StampedPose> truth = Poses({{0, 0, 0}, {1, 0, 0}});
  std::vector<StampedPose> estimate = truth;
  estimate[1] = ToStampedPose(1, {1, 0, 0}, {.pitch_rad = 0.2, .roll_rad = -0.1, .lift_m = 0.3});
  const auto errors = EvaluateTrajectory(truth, estimate, {.align = Alignment::kNone});
  ASSERT_TRUE(errors);
  EXPECT_TRUE(errors->tilted);
  EXPECT_DOUBLE_EQ(errors->position_m.max, 0);
  EXPECT_DOUBLE_EQ(errors->pose.translation_m.max, 0.3);
  // Of Ry(a) Rx(b): cos(angle / 2) = cos(a / 2) cos(b / 2).
  const double angle = 2 * std::acos(std::cos(0.1) * std::cos(0.05));
  EXPECT_NEAR(errors->pose.rotation_deg.max, angle * kDegPerRad, 1e-9);
  EXPECT_NEAR(errors->frames[1].pitch_deg, 0.2 * kDegPerRad, 1e-12);
  EXPECT_NEAR(errors->frames[1].roll_deg, -0.1 * kDegPerRad, 1e-12);
  EXPECT_DOUBLE_EQ(errors->per_frame->translation_m.max, 0.3);
}

TEST(EvaluateTrajectory, CoverageOfWhatThereShouldBe) {
  const std::vector<StampedPose> poses = Poses({{0, 0, 0}, {1, 0, 0}});
  const auto errors = EvaluateTrajectory(poses, poses, {.expected = 8});
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->expected, 8);
  EXPECT_DOUBLE_EQ(errors->Coverage(), 0.25);
  EXPECT_FALSE(errors->per_metre);  // consecutive motions begin after the first metre
  EXPECT_EQ(errors->per_metre_all_pairs->translation_m.count, 1);
}

TEST(EvaluateTrajectory, MatchesNearestStampsOnce) {
  std::vector<StampedPose> truth = Poses({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}});
  std::vector<StampedPose> estimate = Poses({{0, 0, 0}, {2, 0, 0}, {2.5, 0, 0}});
  estimate[0].stamp_s = 0.015;  // near 0
  estimate[1].stamp_s = 1.990;  // near 2, and nearer than ...
  estimate[2].stamp_s = 2.5;    // ... nothing
  const auto errors = EvaluateTrajectory(truth, estimate, {.align = Alignment::kNone});
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->matched, 2);
  EXPECT_EQ(errors->expected, 4);
  EXPECT_DOUBLE_EQ(errors->Coverage(), 0.5);
  EXPECT_DOUBLE_EQ(errors->position_m.max, 0);
}

TEST(EvaluateTrajectory, NoCommonStampsIsNoAnswer) {
  EXPECT_FALSE(EvaluateTrajectory(Poses({{0, 0, 0}}), Poses({{0, 0, 0}}, 100)));
}

TEST(EvaluateTrajectory, YawErrorsWrap) {
  const auto errors =
      EvaluateTrajectory(Poses({{0, 0, 3.1}}), Poses({{0, 0, -3.1}}), {.align = Alignment::kNone});
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->yaw_deg.max, (2 * std::numbers::pi - 6.2) * kDegPerRad, 1e-12);
}

}  // namespace
}  // namespace ceilmap::evaluation
