#include "calib/base/twist2.hpp"

#include <gtest/gtest.h>

namespace ceilmap {
namespace {

TEST(Twist2, OverIsTheInverseOfMean) {
  const Pose2 motion{0.3, -0.1, 0.8};
  const Pose2 again = Twist2::Mean(motion, 0.25).Over(0.25);
  EXPECT_NEAR(again.x, motion.x, 1e-12);
  EXPECT_NEAR(again.y, motion.y, 1e-12);
  EXPECT_NEAR(again.yaw, motion.yaw, 1e-12);
}

TEST(Twist2, BackwardsInTimeUndoesTheMotion) {
  const Twist2 velocity{{1.2, 0.1}, -0.7};
  const Pose2 there_and_back = velocity.Over(0.5) * velocity.Over(-0.5);
  EXPECT_NEAR(there_and_back.x, 0, 1e-12);
  EXPECT_NEAR(there_and_back.y, 0, 1e-12);
  EXPECT_NEAR(there_and_back.yaw, 0, 1e-12);
}

}  // namespace
}  // namespace ceilmap
