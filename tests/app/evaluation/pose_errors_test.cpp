// Numbers worked out by hand from the definitions that evo publishes (evo/core/metrics.py).

#include "app/evaluation/pose_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ceilmap::evaluation {
namespace {

const double kHalf = std::sqrt(0.5);
const Eigen::Quaterniond kQuarterLeft(kHalf, 0, 0, kHalf);
const Eigen::Quaterniond kOnItsBack(0, 1, 0, 0);  // half a turn about x

StampedPose At(const Eigen::Vector3d& position,
               const Eigen::Quaterniond& orientation = Eigen::Quaterniond::Identity()) {
  return {0, position, orientation};
}

TEST(AbsoluteError, OfPosesInSpace) {
  // A 3-4-5 triangle on the floor.
  const PoseError moved = AbsoluteError({At({1, 2, 3}), At({1.3, 2.4, 3})});
  EXPECT_NEAR(moved.translation_m, 0.5, 1e-15);
  EXPECT_EQ(moved.angle_rad, 0);
  EXPECT_NEAR(moved.Full(), 0.5, 1e-15);
  // R - I has the elements -1 -1 / 1 -1.
  const PoseError turned = AbsoluteError({At({1, 2, 3}), At({1, 2, 3}, kQuarterLeft)});
  EXPECT_NEAR(turned.angle_rad, std::numbers::pi / 2, 1e-15);
  EXPECT_NEAR(turned.RotationPart(), 2, 1e-15);
  EXPECT_NEAR(turned.Full(), 2, 1e-15);
  // R - I = diag(0, -2, -2); with the shift 8 + 1.44.
  const PoseError both = AbsoluteError({At({1, 2, 3}), At({1, 2, 4.2}, kOnItsBack)});
  EXPECT_NEAR(both.translation_m, 1.2, 1e-15);
  EXPECT_NEAR(both.angle_rad, std::numbers::pi, 1e-15);
  EXPECT_NEAR(both.RotationPart(), std::sqrt(8), 1e-15);
  EXPECT_NEAR(both.Full(), std::sqrt(9.44), 1e-15);
}

TEST(AbsoluteError, SmallAnglesAndLongQuaternions) {
  const Eigen::Quaterniond tiny(Eigen::AngleAxisd(1e-9, Eigen::Vector3d::UnitY()));
  Eigen::Quaterniond longer = tiny;
  longer.coeffs() *= -1.0005;  // the same rotation
  EXPECT_NEAR(AbsoluteError({At({0, 0, 0}), At({0, 0, 0}, tiny)}).angle_rad, 1e-9, 1e-20);
  EXPECT_NEAR(AbsoluteError({At({0, 0, 0}), At({0, 0, 0}, longer)}).angle_rad, 1e-9, 1e-20);
}

TEST(PoseErrorStatistics, OfTheFourPartsOfAnError) {
  // Translations 0, 0.5, 0, 1.2; angles 0, 0, 90, 180 deg; full 0, 0.5, 2, sqrt(9.44).
  const PoseErrorStatistics s =
      Statistics({AbsoluteError({At({0, 0, 0}), At({0, 0, 0})}),
                  AbsoluteError({At({1, 0, 0}), At({1.3, 0.4, 0})}),
                  AbsoluteError({At({2, 0, 0}), At({2, 0, 0}, kQuarterLeft)}),
                  AbsoluteError({At({3, 0, 0}), At({3, 0, 1.2}, kOnItsBack)})});
  EXPECT_EQ(s.translation_m.count, 4);
  EXPECT_NEAR(s.translation_m.rmse, 0.65, 1e-12);  // sqrt((0.25 + 1.44) / 4)
  EXPECT_NEAR(s.translation_m.mean, 0.425, 1e-12);
  EXPECT_NEAR(s.translation_m.median, 0.25, 1e-12);
  EXPECT_NEAR(s.translation_m.std, std::sqrt(0.4225 - 0.425 * 0.425), 1e-12);
  EXPECT_NEAR(s.translation_m.min, 0, 1e-12);
  EXPECT_NEAR(s.translation_m.max, 1.2, 1e-12);
  EXPECT_NEAR(s.rotation_deg.mean, 67.5, 1e-12);
  EXPECT_NEAR(s.rotation_deg.rmse, std::sqrt((8100 + 32400) / 4.0), 1e-12);
  EXPECT_NEAR(s.rotation_block.rmse, std::sqrt((4 + 8) / 4.0), 1e-12);
  EXPECT_NEAR(s.full.rmse, 1.85, 1e-12);  // sqrt((0.25 + 4 + 9.44) / 4)
}

TEST(RelativeError, TurnsWithTheRobot) {
  const PosePair from{At({1, 0, 0}), At({1, 0, 0}, kQuarterLeft)};
  // The estimate also moves along its own x, half a metre further.
  const PoseError same = RelativeError(from, {At({2, 0, 0}), At({1, 1.5, 0}, kQuarterLeft)});
  EXPECT_NEAR(same.translation_m, 0.5, 1e-15);
  EXPECT_NEAR(same.angle_rad, 0, 1e-15);
  // It turns where the truth does not: what it moved by stays the same.
  const PoseError turned = RelativeError(from, {At({2, 0, 0}), At({1, 1, 0}, kOnItsBack)});
  EXPECT_NEAR(turned.translation_m, 0, 1e-15);
  EXPECT_NEAR(turned.angle_rad, std::numbers::pi, 1e-15);
}

}  // namespace
}  // namespace ceilmap::evaluation
