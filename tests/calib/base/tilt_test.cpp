#include "calib/base/tilt.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace ceilmap {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Tilt MakeTilt(double pitch_rad, double roll_rad, double lift_m) {
  return {pitch_rad, roll_rad, lift_m, Eigen::Matrix2d::Zero()};
}

TEST(Tilt, PitchLowersThePointAheadAndRollRaisesTheLeftSide) {
  const Vector3d ahead(1, 0, 0);
  const Vector3d left(0, 1, 0);
  const Isometry3d nose_down = MakeTilt(30 * kRadPerDeg, 0, 0).T_level_base();
  EXPECT_NEAR((nose_down * ahead - Vector3d(std::sqrt(0.75), 0, -0.5)).norm(), 0, 1e-15);
  EXPECT_NEAR((nose_down * left - left).norm(), 0, 1e-15);
  const Isometry3d left_up = MakeTilt(0, 30 * kRadPerDeg, 0).T_level_base();
  EXPECT_NEAR((left_up * left - Vector3d(0, std::sqrt(0.75), 0.5)).norm(), 0, 1e-15);
  EXPECT_NEAR((left_up * ahead - ahead).norm(), 0, 1e-15);
  // Nose down tips the mast ahead, left side up tips it to the right; the foot rises by the lift.
  const Vector3d top(0, 0, 2);
  EXPECT_NEAR((nose_down * top - Vector3d(1, 0, 2 * std::sqrt(0.75))).norm(), 0, 1e-15);
  EXPECT_NEAR((left_up * top - Vector3d(0, -1, 2 * std::sqrt(0.75))).norm(), 0, 1e-15);
  EXPECT_EQ(MakeTilt(0.2, 0.1, 0.03).T_level_base().translation(), Vector3d(0, 0, 0.03));
}

// Turned by 90 degrees to the left, what is ahead of the robot is along y of the map.
TEST(Tilt, IsInTheRobotsOwnAxesNotTheMaps) {
  const Isometry3d T = ToSpace({3, -2, std::numbers::pi / 2}, MakeTilt(30 * kRadPerDeg, 0, 0.1));
  const Vector3d ahead = T * Vector3d(1, 0, 0);
  EXPECT_NEAR((ahead - Vector3d(3, -2 + std::sqrt(0.75), 0.1 - 0.5)).norm(), 0, 1e-15);
}

// Both quarter turns: rolled first, then pitched. The other order would send z to -y.
TEST(Tilt, PitchesAboutTheLevelYAxisAfterRolling) {
  const Isometry3d T = MakeTilt(std::numbers::pi / 2, std::numbers::pi / 2, 0).T_level_base();
  EXPECT_NEAR((T * Vector3d::UnitZ() - Vector3d(0, -1, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((T * Vector3d::UnitX() - Vector3d(0, 0, -1)).norm(), 0, 1e-15);
  EXPECT_NEAR((T * Vector3d::UnitY() - Vector3d(1, 0, 0)).norm(), 0, 1e-15);
}

TEST(Tilt, FromSpaceIsTheInverseOfToSpace) {
  std::mt19937 random(11);
  const auto draw = [&](double limit) {
    return std::uniform_real_distribution<double>(-limit, limit)(random);
  };
  for (int i = 0; i < 500; ++i) {
    const Pose2 pose{draw(20), draw(20), draw(std::numbers::pi)};
    const Tilt tilt = MakeTilt(draw(1.5), draw(3), draw(0.3));
    const PlanarTilt back = FromSpace(ToSpace(pose, tilt));
    EXPECT_NEAR(back.pose.x, pose.x, 1e-12);
    EXPECT_NEAR(back.pose.y, pose.y, 1e-12);
    EXPECT_NEAR(WrapAngle(back.pose.yaw - pose.yaw), 0, 1e-12);
    EXPECT_NEAR(back.tilt.pitch_rad, tilt.pitch_rad, 1e-12);
    EXPECT_NEAR(back.tilt.roll_rad, tilt.roll_rad, 1e-12);
    EXPECT_NEAR(back.tilt.lift_m, tilt.lift_m, 1e-12);
    EXPECT_TRUE(back.tilt.covariance.isZero());
  }
}

TEST(Tilt, IsLevelWithoutAnyOfTheThreeWhateverItsCovariance) {
  Tilt tilt;
  tilt.covariance.setIdentity();
  EXPECT_TRUE(tilt.IsLevel());
  EXPECT_FALSE(MakeTilt(1e-9, 0, 0).IsLevel());
  EXPECT_FALSE(MakeTilt(0, 1e-9, 0).IsLevel());
  EXPECT_FALSE(MakeTilt(0, 0, 1e-9).IsLevel());
}

}  // namespace
}  // namespace ceilmap
