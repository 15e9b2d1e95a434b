// The mount of a camera from steps of a robot whose wheels do not slip sideways, and from odometry.

#include "compensation/mount/wheel_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/base/degrees.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::mount {
namespace {

constexpr double kDistanceM = 2.2;
constexpr double kAheadM = 0.14;  // of the axle
constexpr double kAsideM = 0.03;
constexpr double kYawRad = 100 * kRadPerDeg;
constexpr double kStepS = 0.1;

/// Poses of the axle: straight, a turn on the spot, straight, an arc to the right; accelerations
/// last some steps.
std::vector<Pose2> AxlePath(double turn_rad_s = 0.8) {
  std::vector<Pose2> path{{}};
  const auto drive = [&path](int steps, double speed_m_s, double rate_rad_s) {
    for (int i = 0; i < steps; ++i) {
      const double ramp = std::min({1.0, (i + 1) / 4.0, (steps - i) / 4.0});
      const double turn = ramp * rate_rad_s * kStepS;
      // A step along an arc: the chord has the mean heading.
      const Pose2 half{0, 0, turn / 2};
      path.push_back(path.back() * half * Pose2{ramp * speed_m_s * kStepS, 0, 0} * half);
    }
  };
  drive(20, 0.6, 0);
  drive(20, 0, turn_rad_s);
  drive(20, 0.6, 0);
  drive(20, 0.5, -turn_rad_s / 2);
  return path;
}

/// What the camera sees of it.
std::vector<DriveStep> StepsOf(const std::vector<Pose2>& axle, double late_s = 0) {
  const Pose2 T_axle_camera{kAheadM / kDistanceM, kAsideM / kDistanceM, kYawRad};
  std::vector<DriveStep> steps;
  for (std::size_t i = 0; i + 1 < axle.size(); ++i) {
    const auto camera = [&](const Pose2& at) {
      return Pose2{at.x / kDistanceM, at.y / kDistanceM, at.yaw} * T_axle_camera;
    };
    const Pose2 step = camera(axle[i]).Inverse() * camera(axle[i + 1]);
    const double start_s = kStepS * static_cast<double>(i) + late_s;
    steps.push_back(
        {start_s, start_s + kStepS, Pose2{0, 0, -step.yaw / 2} * step.Translation(), step.yaw});
  }
  return steps;
}

std::vector<StampedPose> OdometryOf(const std::vector<Pose2>& axle) {
  std::vector<StampedPose> odometry;
  for (std::size_t i = 0; i < axle.size(); ++i) {
    odometry.push_back(ToStampedPose(kStepS * static_cast<double>(i), axle[i]));
  }
  return odometry;
}

TEST(WheelMotion, GivesYawAndAxle) {
  const auto motion = FitWheels(StepsOf(AxlePath()));
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->yaw_rad.value, kYawRad, 1e-6);
  EXPECT_NEAR(motion->ahead.value, kAheadM / kDistanceM, 1e-6);
  EXPECT_LT(motion->slip, 0.001);
}

TEST(WheelMotion, TakesMostOfTheDriveAsAhead) {
  std::vector<Pose2> path = AxlePath();
  std::vector<Pose2> back(path.rbegin(), path.rend());
  const auto motion = FitWheels(StepsOf(back));
  ASSERT_TRUE(motion);
  EXPECT_NEAR(WrapAngle(motion->yaw_rad.value - kYawRad - 180 * kRadPerDeg), 0, 1e-6);
  EXPECT_NEAR(motion->ahead.value, -kAheadM / kDistanceM, 1e-6);
}

TEST(WheelMotion, ARobotThatDrivesSidewaysSlips) {
  std::vector<Pose2> path;
  for (int i = 0; i < 40; ++i) path.push_back({std::sin(0.2 * i), std::cos(0.3 * i), 0.03 * i});
  const auto motion = FitWheels(StepsOf(path));
  ASSERT_TRUE(motion);
  EXPECT_GT(motion->slip, 0.2);
}

TEST(WheelMotion, NeedsSomeSteps) {
  const std::vector<DriveStep> steps = StepsOf(AxlePath());
  EXPECT_FALSE(FitWheels({steps.begin(), steps.begin() + 4}));
}

TEST(OdometryFit, GivesDistanceYawAndTheDelayOfTheStamps) {
  const std::vector<Pose2> path = AxlePath();
  for (const double late_s : {0.0, 0.05, -0.12}) {
    const auto fit = FitOdometry(StepsOf(path, late_s), OdometryOf(path));
    ASSERT_TRUE(fit);
    EXPECT_FALSE(fit->mirrored);
    EXPECT_NEAR(fit->distance_m.value, kDistanceM, 0.01);
    EXPECT_NEAR(fit->yaw_rad.value, kYawRad, 0.2 * kRadPerDeg);
    ASSERT_TRUE(fit->late_s);
    EXPECT_NEAR(fit->late_s->value, late_s, 0.003);
    EXPECT_LT(fit->late_s->sigma, 0.01);
  }
}

TEST(OdometryFit, SeesThatImagesAreMirrored) {
  std::vector<DriveStep> steps = StepsOf(AxlePath());
  for (DriveStep& step : steps) {
    step.turn_rad = -step.turn_rad;
    step.moved.x() = -step.moved.x();
  }
  const auto fit = FitOdometry(steps, OdometryOf(AxlePath()));
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->mirrored);
}

TEST(OdometryFit, ASteadyCircleDoesNotShowTheDelay) {
  std::vector<Pose2> path;
  for (int i = 0; i < 60; ++i) {
    path.push_back({std::cos(0.06 * i), std::sin(0.06 * i), WrapAngle(0.06 * i + 1.5708)});
  }
  const auto fit = FitOdometry(StepsOf(path), OdometryOf(path));
  ASSERT_TRUE(fit);
  EXPECT_FALSE(fit->late_s);
}

TEST(OdometryFit, NeedsTurnsAtItsTime) {
  const std::vector<Pose2> path = AxlePath();
  EXPECT_FALSE(FitOdometry(StepsOf(AxlePath(0.1)), OdometryOf(AxlePath(0.1))));
  EXPECT_FALSE(FitOdometry(StepsOf(path, 1000), OdometryOf(path)));
}

}  // namespace
}  // namespace ceilmap::mount
