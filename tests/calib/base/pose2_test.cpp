#include "calib/base/pose2.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

namespace ceilmap {
namespace {

constexpr double kPi = std::numbers::pi;

Pose2 RandomPose(std::mt19937& random) {
  std::uniform_real_distribution<double> metres(-20, 20);
  std::uniform_real_distribution<double> radians(-kPi, kPi);
  return {metres(random), metres(random), WrapAngle(radians(random))};
}

void ExpectSame(const Pose2& a, const Pose2& b) {
  EXPECT_NEAR(a.x, b.x, 1e-12);
  EXPECT_NEAR(a.y, b.y, 1e-12);
  EXPECT_NEAR(WrapAngle(a.yaw - b.yaw), 0, 1e-13);
}

TEST(WrapAngle, HalfOpenInterval) {
  EXPECT_EQ(WrapAngle(0), 0);
  EXPECT_EQ(WrapAngle(kPi), kPi);
  EXPECT_EQ(WrapAngle(-kPi), kPi);
  EXPECT_EQ(WrapAngle(3 * kPi), kPi);
  EXPECT_NEAR(WrapAngle(kPi + 0.1), -kPi + 0.1, 1e-15);
  EXPECT_NEAR(WrapAngle(-kPi - 0.1), kPi - 0.1, 1e-15);
  EXPECT_NEAR(WrapAngle(2e6 * kPi + 0.25), 0.25, 1e-9);
}

TEST(WrapAngle, StaysInRangeAndKeepsTheDirection) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angles(-100, 100);
  for (int i = 0; i < 1000; ++i) {
    const double angle = angles(random);
    const double wrapped = WrapAngle(angle);
    EXPECT_GT(wrapped, -kPi);
    EXPECT_LE(wrapped, kPi);
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), 1e-12);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), 1e-12);
  }
}

// A robot at (2, 1) that faces +y: what is 3 m ahead of it lies at (2, 4), what is 1 m to its
// left at (1, 1).
TEST(Pose2, TakesPointsOfBaseToMap) {
  const Pose2 T_map_base{2, 1, kPi / 2};
  EXPECT_TRUE((T_map_base * Eigen::Vector2d(3, 0)).isApprox(Eigen::Vector2d(2, 4), 1e-15));
  EXPECT_TRUE((T_map_base * Eigen::Vector2d(0, 1)).isApprox(Eigen::Vector2d(1, 1), 1e-15));
}

TEST(Pose2, ComposesByHand) {
  // Ahead by 1 and left turn, then ahead by 2 (now along +y), then a turn past pi.
  const Pose2 T = Pose2{1, 0, kPi / 2} * Pose2{2, 0, 3 * kPi / 4};
  ExpectSame(T, {1, 2, -3 * kPi / 4});
}

TEST(Pose2, IsAGroupThatActsOnPoints) {
  std::mt19937 random(2);
  for (int i = 0; i < 500; ++i) {
    const Pose2 T_a_b = RandomPose(random);
    const Pose2 T_b_c = RandomPose(random);
    const Pose2 T_c_d = RandomPose(random);
    const Eigen::Vector2d p_c = RandomPose(random).Translation();
    ExpectSame((T_a_b * T_b_c) * T_c_d, T_a_b * (T_b_c * T_c_d));
    ExpectSame(T_a_b * T_a_b.Inverse(), {});
    ExpectSame(T_a_b.Inverse() * T_a_b, {});
    EXPECT_LT(((T_a_b * T_b_c) * p_c - T_a_b * (T_b_c * p_c)).norm(), 1e-12);
    EXPECT_NEAR(T_a_b.Rotation().determinant(), 1, 1e-15);
  }
}

}  // namespace
}  // namespace ceilmap
