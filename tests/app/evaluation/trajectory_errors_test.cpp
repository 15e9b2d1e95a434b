#include "app/evaluation/trajectory_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ceilmap::evaluation {
namespace {

using calib::Pose2;

constexpr double kDegPerRad = 180 / std::numbers::pi;

std::vector<StampedPose> Poses(const std::vector<Pose2>& planar, double first_s = 0) {
  std::vector<StampedPose> poses;
  poses.reserve(planar.size());
  for (const Pose2& pose : planar) {
    poses.push_back(ToStampedPose(first_s + static_cast<double>(poses.size()), pose));
  }
  return poses;
}

TEST(Statistics, OfAbsoluteValues) {
  const ErrorStatistics s = Statistics({-4, 1, 3, 2});
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(30.0 / 4));
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.p95, 3.85);  // rank 0.95 * 3 = 2.85, between 3 and 4
  EXPECT_DOUBLE_EQ(s.max, 4);
  EXPECT_DOUBLE_EQ(Statistics({7}).p95, 7);
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
