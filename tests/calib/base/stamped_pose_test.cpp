#include "calib/base/stamped_pose.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ceilmap {
namespace {

TEST(StampedPose, APlanarPoseIsLevelAndKeepsItsYaw) {
  for (const double yaw : {0.0, 0.5, -2.0, std::numbers::pi}) {
    const StampedPose pose = ToStampedPose(3, {1, 2, yaw});
    EXPECT_EQ(pose.position, Eigen::Vector3d(1, 2, 0));
    EXPECT_NEAR(std::remainder(YawOf(pose) - yaw, 2 * std::numbers::pi), 0, 1e-15);
    EXPECT_EQ(pose.orientation.x(), 0);
    EXPECT_EQ(pose.orientation.y(), 0);
  }
}

TEST(StampedPose, YawIsCounterClockwiseFromAbove) {
  // A quarter turn to the left takes x forward to y left.
  const StampedPose pose = ToStampedPose(0, {0, 0, std::numbers::pi / 2});
  EXPECT_LT((pose.orientation * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-15);
}

TEST(StampedPose, PitchIsNoseDownAndRollLeftSideUp) {
  const auto lifts = [](double pitch_rad, double roll_rad, const Eigen::Vector3d& p_base) {
    Tilt tilt;
    tilt.pitch_rad = pitch_rad;
    tilt.roll_rad = roll_rad;
    const StampedPose pose = ToStampedPose(0, {1, 2, 2.5}, tilt);
    EXPECT_NEAR(PitchOf(pose), pitch_rad, 1e-15);
    EXPECT_NEAR(RollOf(pose), roll_rad, 1e-15);
    return (pose.orientation * p_base).z() > 0;
  };
  EXPECT_FALSE(lifts(0.1, 0, Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(lifts(-0.1, 0, Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(lifts(0, 0.1, Eigen::Vector3d::UnitY()));
  lifts(-0.3, 0.4, Eigen::Vector3d::UnitZ());
}

}  // namespace
}  // namespace ceilmap
