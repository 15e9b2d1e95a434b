#include "calib/base/velocity_predictor.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ceilmap {
namespace {

constexpr double kFrame = 0.04;  // s

/// On a circle of 2 m radius, from rest, with this acceleration along the way.
Pose2 OnCircle(double acceleration_m_s2, double stamp_s) {
  const double angle = 0.5 * acceleration_m_s2 * stamp_s * stamp_s / 2;
  return {2 * std::sin(angle), 2 * (1 - std::cos(angle)), angle};
}

TEST(VelocityPredictor, IsExactForEvenAcceleration) {
  VelocityPredictor predictor;
  EXPECT_FALSE(predictor.At(0));
  for (int i = 0; i < 20; ++i) predictor.AddPose(OnCircle(1.5, i * kFrame), i * kFrame);
  // Two frames ahead, as when frames are measured in the background.
  const Twist2 predicted = predictor.At(21 * kFrame).value();
  EXPECT_NEAR(predicted.linear_m_s.x(), 1.5 * 21 * kFrame, 2e-3);
  EXPECT_NEAR(predicted.linear_m_s.y(), 0, 2e-3);
  EXPECT_NEAR(predicted.yaw_rad_s, 1.5 * 21 * kFrame / 2, 1e-3);
}

TEST(VelocityPredictor, ForgetsWhatIsLongAgo) {
  VelocityPredictor predictor;
  predictor.Add({1.0, {{0.5, 0}, 0.1}});
  EXPECT_EQ(predictor.At(1.4)->linear_m_s.x(), 0.5);
  EXPECT_FALSE(predictor.At(1.6));
}

TEST(VelocityPredictor, AChangeDoesNotGoOnWithoutMeasurements) {
  VelocityPredictor predictor;
  predictor.Add({0.00, {{0.5, 0}, 0}});
  predictor.Add({0.04, {{0.6, 0}, 0}});
  EXPECT_NEAR(predictor.At(0.08)->linear_m_s.x(), 0.7, 1e-12);
  EXPECT_NEAR(predictor.At(0.16)->linear_m_s.x(), 0.9, 1e-12);
  EXPECT_NEAR(predictor.At(0.5)->linear_m_s.x(), 0.9, 1e-12);
}

TEST(VelocityPredictor, OneJumpOfThePoseIsNoMotion) {
  VelocityPredictor predictor;
  for (int i = 0; i < 5; ++i) predictor.AddPose(Pose2{0.02 * i, 0, 0}, i * kFrame);
  // A loop was closed: the map, and the robot on it, moved by 10 cm.
  for (int i = 5; i < 8; ++i) {
    predictor.AddPose(Pose2{0.02 * i, 0.1, 0}, i * kFrame);
    EXPECT_NEAR(predictor.At((i + 1) * kFrame)->linear_m_s.x(), 0.5, 1e-9);
    EXPECT_NEAR(predictor.At((i + 1) * kFrame)->linear_m_s.y(), 0, 1e-9);
  }
}

TEST(VelocityPredictor, TheSecondOfTwoJumpsIsMotion) {
  VelocityPredictor predictor;
  predictor.Add({0.00, {{0, 0}, 0}});
  predictor.Add({0.04, {{2, 0}, 0}});
  EXPECT_EQ(predictor.At(0.04)->linear_m_s.x(), 0);
  predictor.Add({0.08, {{2, 0}, 0}});
  EXPECT_EQ(predictor.At(0.10)->linear_m_s.x(), 2);
}

TEST(VelocityPredictor, PosesWithAGapGiveNone) {
  VelocityPredictor predictor;
  predictor.AddPose(Pose2{0, 0, 0}, 0.00);
  predictor.AddPose(std::nullopt, 0.04);
  predictor.AddPose(Pose2{0.3, 0, 0}, 0.08);
  EXPECT_FALSE(predictor.At(0.1));
}

}  // namespace
}  // namespace ceilmap
