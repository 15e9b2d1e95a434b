#include "localization/compass/turn_check.hpp"

#include <gtest/gtest.h>

namespace ceilmap::compass {
namespace {

using wheels::RelativeTurn;
using Verdict = TurnCheck::Verdict;

constexpr double kVariance = 1e-6;
constexpr RelativeTurn kWheels{0.1, kVariance, 0, true};
constexpr RelativeTurn kGyro{0.1, kVariance, 0, false};

TEST(TurnCheck, AgreesWithinBothErrors) {
  TurnCheck check;
  check.Begin(kGyro);
  // 4 sigma of 0.0014, and 0.01.
  EXPECT_FALSE(check.Contradicts(0.115, kVariance));
  EXPECT_TRUE(check.Contradicts(0.117, kVariance));
  EXPECT_FALSE(check.Contradicts(0.117, 9 * kVariance));
  EXPECT_EQ(check.Judge(0.115, kVariance), Verdict::kAgrees);
  EXPECT_EQ(check.Judge(0.117, kVariance), Verdict::kDropped);
}

TEST(TurnCheck, TurnsAddUpUntilAFrameIsMeasured) {
  TurnCheck check;
  check.Begin(kGyro);
  check.Begin(kGyro);
  ASSERT_TRUE(check.SinceMeasured());
  EXPECT_DOUBLE_EQ(check.SinceMeasured()->turn_rad, 0.2);
  EXPECT_DOUBLE_EQ(check.SinceMeasured()->noise_rad2, 2 * kVariance);
  check.Measured();
  check.Begin(kGyro);
  EXPECT_DOUBLE_EQ(check.SinceMeasured()->turn_rad, 0.1);
  EXPECT_NEAR(check.SinceReference()->turn_rad, 0.3, 1e-12);
  EXPECT_FALSE(check.SinceReference()->may_slip);
}

TEST(TurnCheck, AGapLeavesNothingToCompareWith) {
  TurnCheck check;
  check.Begin(kGyro);
  check.Begin(std::nullopt);
  check.Begin(kGyro);
  EXPECT_FALSE(check.SinceMeasured());
  EXPECT_EQ(check.Judge(2, kVariance), Verdict::kAgrees);
  check.Measured();
  check.Begin(kGyro);
  EXPECT_TRUE(check.SinceMeasured());
  EXPECT_FALSE(check.SinceReference());  // until there is a new one
  check.RefersToThis();
  check.Begin(kGyro);
  EXPECT_DOUBLE_EQ(check.SinceReference()->turn_rad, 0.1);
}

TEST(TurnCheck, TheMeasuredFrameMayBecomeTheReferenceLater) {
  TurnCheck check;
  check.Begin(kGyro);
  check.Measured();
  check.Begin(kWheels);
  const auto edge = check.RefersToMeasured();
  ASSERT_TRUE(edge);
  EXPECT_DOUBLE_EQ(edge->turn_rad, 0.1);
  EXPECT_FALSE(edge->may_slip);
  EXPECT_DOUBLE_EQ(check.SinceReference()->turn_rad, 0.1);
  EXPECT_TRUE(check.SinceReference()->may_slip);
}

TEST(TurnCheck, FiveFramesAtTheSameAngleTellASlip) {
  TurnCheck check;
  double seen = 0;
  for (int i = 1; i <= 4; ++i) {
    check.Begin(kWheels);
    seen += 0.1;
    EXPECT_EQ(check.Judge(seen - 0.5, kVariance), Verdict::kDropped);
    EXPECT_TRUE(check.Waits());
    EXPECT_NEAR(check.DisagreementVariance(), 0.25, 1e-9);
  }
  check.Begin(kWheels);
  EXPECT_EQ(check.Judge(seen + 0.1 - 0.5, kVariance), Verdict::kSlipped);
  EXPECT_FALSE(check.SinceReference());  // it contains the slip
}

TEST(TurnCheck, WhatMovesOnIsNoSlip) {
  TurnCheck check;
  for (int i = 1; i <= 20; ++i) {
    check.Begin(kWheels);
    EXPECT_EQ(check.Judge(0.1 * i + 0.04 * i, kVariance), Verdict::kDropped) << i;
    EXPECT_TRUE(check.Waits());
  }
}

TEST(TurnCheck, AGyroDoesNotSlipNorDoWheelsByHalfATurn) {
  TurnCheck gyro;
  TurnCheck wheels;
  for (int i = 1; i <= 10; ++i) {
    gyro.Begin(kGyro);
    EXPECT_EQ(gyro.Judge(0.1 * i - 0.5, kVariance), Verdict::kDropped);
    EXPECT_FALSE(gyro.Waits());
    EXPECT_EQ(gyro.DisagreementVariance(), 0);
    wheels.Begin(kWheels);
    EXPECT_EQ(wheels.Judge(0.1 * i + 3, kVariance), Verdict::kDropped);
    EXPECT_GT(wheels.DisagreementVariance(), 8);
  }
  EXPECT_FALSE(wheels.Waits());
}

}  // namespace
}  // namespace ceilmap::compass
