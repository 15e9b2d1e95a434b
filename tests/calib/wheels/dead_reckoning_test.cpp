#include "calib/wheels/dead_reckoning.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calib/base/error.hpp"

namespace ceilmap::wheels {
namespace {

/// A robot on a circle.
constexpr double kSpeed = 0.8;     // m/s
constexpr double kTurnRate = 0.5;  // rad/s

Pose2 OnCircle(double stamp_s) {
  return Pose2{kSpeed / kTurnRate * std::sin(kTurnRate * stamp_s),
               kSpeed / kTurnRate * (1 - std::cos(kTurnRate * stamp_s)),
               WrapAngle(kTurnRate * stamp_s)};
}

/// Noise of a gyro: no two values are the same.
double Jitter(int sample) {
  return sample % 2 == 0 ? 1e-6 : -1e-6;
}

WheelModel Exact() {
  WheelModel model;
  model.scale.sigma = 0;
  model.turn_scale.sigma = 0;
  model.gyro_bias_rad_s.sigma = 0;
  return model;
}

void ExpectNear(const Pose2& a, const Pose2& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(WrapAngle(a.yaw - b.yaw), 0, tolerance);
}

TEST(DeadReckoning, FollowsACircleBetweenSamples) {
  DeadReckoning wheels(Exact());
  for (int i = 0; i <= 40; ++i) wheels.Add(OdometrySample{0.05 * i, OnCircle(0.05 * i)});
  const auto motion = wheels.Between(0.313, 1.731);
  ASSERT_TRUE(motion);
  ExpectNear(motion->T_before_now, OnCircle(0.313).Inverse() * OnCircle(1.731), 2e-4);
}

TEST(DeadReckoning, IntegratesSpeeds) {
  DeadReckoning wheels(Exact());
  for (int i = 0; i <= 200; ++i) {
    wheels.Add(WheelSpeedSample{0.01 * i, {{kSpeed, 0}, kTurnRate}});
  }
  const auto motion = wheels.Between(0.5, 1.5);
  ASSERT_TRUE(motion);
  ExpectNear(motion->T_before_now, OnCircle(0.5).Inverse() * OnCircle(1.5), 1e-4);
}

TEST(DeadReckoning, CorrectsScaleTurnAndClock) {
  WheelModel model = Exact();
  model.scale.value = 1.02;
  model.turn_scale.value = 0.95;
  model.late_s.value = 0.1;
  DeadReckoning wheels(model);
  // What wheels report that are 2 % too large in their own opinion, and whose clock is late.
  const Twist2 reported{{kSpeed / 1.02, 0}, kTurnRate / 0.95};
  Pose2 pose;
  for (int i = 0; i <= 200; ++i) {
    wheels.Add(OdometrySample{0.02 * i + 0.1, pose});
    pose = pose * reported.Over(0.02);
  }
  const auto motion = wheels.Between(1, 3);
  ASSERT_TRUE(motion);
  ExpectNear(motion->T_before_now, OnCircle(1).Inverse() * OnCircle(3), 1e-3);
}

TEST(DeadReckoning, TheGyroGivesTheTurn) {
  WheelModel model = Exact();
  model.gyro_bias_rad_s.value = 0.03;
  DeadReckoning wheels(model);
  // Wheels that slip while turning: they report twice the turn.
  for (int i = 0; i <= 100; ++i) {
    wheels.Add(WheelSpeedSample{0.02 * i, {{kSpeed, 0}, 2 * kTurnRate}});
  }
  for (int i = 0; i <= 200; ++i) wheels.Add(GyroSample{0.01 * i, kTurnRate + 0.03 + Jitter(i)});
  const auto motion = wheels.Between(0.25, 1.75);
  ASSERT_TRUE(motion);
  ExpectNear(motion->T_before_now, OnCircle(0.25).Inverse() * OnCircle(1.75), 1e-3);
}

TEST(DeadReckoning, AGyroThatIsStuckMeasuresNoTurn) {
  WheelModel model = Exact();
  model.yaw_noise_per_sqrt_m = 0.02;
  for (const double stuck_rad_s : {0.0, kTurnRate + 0.2}) {
    DeadReckoning wheels(model);
    for (int i = 0; i <= 200; ++i) {
      wheels.Add(WheelSpeedSample{0.02 * i, {{kSpeed, 0}, kTurnRate}});
    }
    for (int i = 0; i <= 400; ++i) {
      const bool stuck = i >= 100 && i < 300;
      wheels.Add(GyroSample{0.01 * i, stuck ? stuck_rad_s : kTurnRate + Jitter(i)});
    }
    EXPECT_NEAR(wheels.StuckSeconds(), 1.99, 1e-9);
    const auto by_gyro = wheels.Between(0.1, 0.9);
    const auto by_wheels = wheels.Between(0.9, 3.1);
    const auto again = wheels.Between(3.1, 3.9);
    ASSERT_TRUE(by_gyro && by_wheels && again);
    ExpectNear(by_wheels->T_before_now, OnCircle(0.9).Inverse() * OnCircle(3.1), 5e-3);
    EXPECT_GT(by_wheels->Covariance()(2, 2), 1.9 * kSpeed * 0.02 * 0.02);
    for (const auto& motion : {by_gyro, again}) {
      EXPECT_NEAR(motion->Covariance()(2, 2),
                  0.8 * model.gyro_noise_per_sqrt_s * model.gyro_noise_per_sqrt_s,
                  1e-9);
    }
    EXPECT_TRUE(wheels.TurnBetween(1.5, 2)->may_slip);
    EXPECT_FALSE(wheels.TurnBetween(3.5, 3.8)->may_slip);
  }
}

// A driver may read a gyro more often than it measures.
TEST(DeadReckoning, AGyroMayRepeatAValueForAMoment) {
  DeadReckoning wheels(Exact());
  for (int i = 0; i <= 100; ++i) wheels.Add(WheelSpeedSample{0.02 * i, {{kSpeed, 0}, 0}});
  for (int i = 0; i <= 400; ++i) wheels.Add(GyroSample{0.005 * i, kTurnRate + Jitter(i / 10)});
  EXPECT_EQ(wheels.StuckSeconds(), 0);
  EXPECT_FALSE(wheels.TurnBetween(0.5, 1.5)->may_slip);
}

TEST(DeadReckoning, WithoutWheelsAGyroMayRepeatItsValue) {
  DeadReckoning gyro(Exact());
  for (int i = 0; i <= 100; ++i) gyro.Add(GyroSample{0.02 * i, 0});
  EXPECT_TRUE(gyro.TurnBetween(0.5, 1.5));
}

TEST(DeadReckoning, SlipsThatWereSeenMayHappenAgain) {
  WheelModel model = Exact();
  const auto drive = [&] {
    DeadReckoning wheels(model);
    for (int i = 0; i <= 200; ++i) wheels.Add(WheelSpeedSample{0.02 * i, {{kSpeed, 0}, 0}});
    return *wheels.Between(0.5, 3) * *wheels.Between(3, 3.5);
  };
  const Eigen::Matrix3d without = drive().Covariance();
  model.slips = {0.1, 0.2};
  const Eigen::Matrix3d with = drive().Covariance();
  const double travel_m = 3 * kSpeed;
  const double slips_m2 = std::pow(0.1 * travel_m, 2) + 0.2 * 0.2 * travel_m;
  for (const int axis : {0, 1}) {
    EXPECT_NEAR(with(axis, axis) - without(axis, axis), slips_m2, 1e-9);
  }
}

TEST(DeadReckoning, TellsNothingAcrossAGap) {
  DeadReckoning wheels;
  EXPECT_FALSE(wheels.Between(0, 1));
  for (int i = 0; i <= 50; ++i) wheels.Add(OdometrySample{0.02 * i, OnCircle(0.02 * i)});
  for (int i = 0; i <= 50; ++i) wheels.Add(OdometrySample{0.02 * i + 2, OnCircle(0.02 * i)});
  EXPECT_TRUE(wheels.Between(0.1, 0.9));
  EXPECT_FALSE(wheels.Between(0.9, 2.1));
  EXPECT_TRUE(wheels.Between(2.1, 3.1));   // held for a moment
  EXPECT_FALSE(wheels.Between(2.1, 3.3));  // not longer
  EXPECT_FALSE(wheels.Between(-0.1, 0.5));
}

// A robot that turns about its axle moves its base, by its turn and not by its travel.
// An odometry that something else corrects, or that begins anew.
TEST(DeadReckoning, TellsNothingAcrossAJump) {
  const auto with_jump = [](const Pose2& jump) {
    DeadReckoning wheels(Exact());
    for (int i = 0; i <= 40; ++i) {
      const Pose2 pose = OnCircle(0.05 * i);
      wheels.Add(OdometrySample{0.05 * i, i < 20 ? pose : jump * pose});
    }
    return wheels;
  };
  for (const Pose2& jump : {Pose2{2, 0, 0}, Pose2{0, -1, 0}, Pose2{0, 0, 2}}) {
    const DeadReckoning wheels = with_jump(jump);
    EXPECT_TRUE(wheels.Between(0.1, 0.9));
    EXPECT_FALSE(wheels.Between(0.9, 1.1));
    EXPECT_TRUE(wheels.Between(1.05, 1.9));
  }
  EXPECT_TRUE(with_jump({0.2, 0, 0}).Between(0.9, 1.1)) << "a slip";
}

// The calibrator reports other units; they must not look like jumps.
TEST(DeadReckoning, OtherUnitsAreNoJumps) {
  DeadReckoning wheels(Exact());
  for (int i = 0; i <= 40; ++i) {
    Pose2 pose = OnCircle(0.05 * i);
    pose.x *= 1000;
    pose.y *= 1000;
    wheels.Add(OdometrySample{0.05 * i, pose});
  }
  EXPECT_TRUE(wheels.Between(0.1, 1.9));
}

// Motions that are computed of it would not be finite.
TEST(DeadReckoning, RefusesWhatIsImpossiblyLarge) {
  DeadReckoning wheels(Exact());
  EXPECT_THROW(wheels.Add(OdometrySample{0, {1e300, 0, 0}}), InputError);
  EXPECT_THROW(wheels.Add(GyroSample{0, 1e300}), InputError);
  EXPECT_THROW(wheels.Add(WheelSpeedSample{0, {{1e300, 0}, 0}}), InputError);
  EXPECT_THROW(wheels.Add(WheelSpeedSample{0, {{0, 0}, -1e300}}), InputError);
  wheels.Add(WheelSpeedSample{0, {{1e6, 0}, 1e6}});
  wheels.Add(WheelSpeedSample{1e300, {{1e6, 0}, 1e6}});
  wheels.Add(GyroSample{0, 1e6});
  wheels.Add(GyroSample{1e300, 1e6});
  EXPECT_FALSE(wheels.Between(0, 1));
}

TEST(DeadReckoning, BaseMayStandBeforeTheAxle) {
  WheelModel model;
  model.scale = {1.1, 0};
  model.turn_scale = {0.9, 0.02};
  constexpr double kAxle = 0.2;
  DeadReckoning poses(model, kAxle);
  DeadReckoning speeds(model, kAxle);
  for (int i = 0; i <= 20; ++i) {
    const double yaw = 0.05 * i;
    poses.Add(OdometrySample{0.1 * i, Pose2{0, 0, yaw} * Pose2{kAxle, 0, 0}});
    speeds.Add(WheelSpeedSample{0.1 * i, {{0, 0}, 0.5}});
  }
  const Pose2 turned = Pose2{-kAxle, 0, 0} * Pose2{0, 0, 0.9} * Pose2{kAxle, 0, 0};
  for (const DeadReckoning* wheels : {&poses, &speeds}) {
    const auto motion = wheels->Between(0, 2);
    ASSERT_TRUE(motion);
    ExpectNear(motion->T_before_now, turned, 1e-9);
    // An error of the turn moves base to the side, by the lever.
    const Eigen::Vector3d common = motion->common.col(1);
    EXPECT_NEAR(common.z(), 0.02, 1e-9);
    EXPECT_NEAR(common.x(), -kAxle * std::sin(0.9) * 0.02, 1e-9);
    EXPECT_NEAR(common.y(), kAxle * std::cos(0.9) * 0.02, 1e-9);
  }
}

TEST(DeadReckoning, TellsTheTurnByAGyroAlone) {
  WheelModel model;
  model.gyro_bias_rad_s = {0.01, 0.002};
  model.gyro_late_s.value = 0.1;
  DeadReckoning gyro(model);
  for (int i = 0; i <= 40; ++i) gyro.Add(GyroSample{0.1 * i, 0.1 * i});  // rate = time
  EXPECT_FALSE(gyro.Between(1, 2));
  const auto turn = gyro.TurnBetween(1, 2);
  ASSERT_TRUE(turn);
  EXPECT_NEAR(turn->turn_rad, (2.1 * 2.1 - 1.1 * 1.1) / 2 - 0.01, 1e-12);
  EXPECT_NEAR(turn->noise_rad2, model.gyro_noise_per_sqrt_s * model.gyro_noise_per_sqrt_s, 1e-15);
  EXPECT_NEAR(turn->common_rad, 0.002, 1e-15);
  EXPECT_NEAR(turn->Variance(), turn->noise_rad2 + 4e-6, 1e-15);
  EXPECT_FALSE(turn->may_slip);
  EXPECT_FALSE(gyro.TurnBetween(-0.2, 0.5));
  EXPECT_FALSE(gyro.TurnBetween(3, 4.2));
}

TEST(DeadReckoning, TellsTheTurnByWheelsWhereThereIsNoGyro) {
  DeadReckoning wheels;
  for (int i = 0; i <= 40; ++i) wheels.Add(OdometrySample{0.1 * i, OnCircle(0.1 * i)});
  const auto motion = wheels.Between(1, 2);
  const auto turn = wheels.TurnBetween(1, 2);
  ASSERT_TRUE(motion && turn);
  EXPECT_NEAR(turn->turn_rad, kTurnRate, 1e-9);
  EXPECT_NEAR(turn->Variance(), motion->Covariance()(2, 2), 1e-15);
  EXPECT_TRUE(turn->may_slip);
  EXPECT_TRUE((RelativeTurn{0, 0, 0, false} + *turn).may_slip);
}

TEST(DeadReckoning, RefusesWhatCannotBe) {
  DeadReckoning wheels;
  wheels.Add(OdometrySample{1, {}});
  EXPECT_THROW(wheels.Add(OdometrySample{1, {}}), InputError);
  EXPECT_THROW(wheels.Add(OdometrySample{2, {NAN, 0, 0}}), InputError);
  EXPECT_THROW(wheels.Add(WheelSpeedSample{2, {}}), InputError);
  EXPECT_THROW(wheels.Add(GyroSample{1, INFINITY}), InputError);
  WheelModel model;
  model.scale.value = 0;
  EXPECT_THROW(wheels.SetModel(model), InputError);
}

/// Simulated wheels: the errors of many drives agree with the covariance that is stated.
TEST(DeadReckoning, StatesItsErrors) {
  WheelModel model;
  model.scale.sigma = 0.02;
  model.turn_scale.sigma = 0.05;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  constexpr int kDrives = 400;
  constexpr double kStepS = 0.02;
  constexpr int kSteps = 150;
  Pose2 truth;
  for (int i = 0; i < kSteps; ++i) truth = truth * OnCircle(kStepS);
  double nees = 0;
  for (int drive = 0; drive < kDrives; ++drive) {
    const double scale = 1 + model.scale.sigma * normal(random);
    const double turn = 1 + model.turn_scale.sigma * normal(random);
    const double length = kSpeed * kStepS;
    DeadReckoning wheels(model);
    Pose2 pose;
    for (int i = 0; i <= kSteps; ++i) {
      wheels.Add(OdometrySample{kStepS * i, pose});
      const double noise = model.travel_noise_per_sqrt_m * std::sqrt(length) * normal(random);
      const double yaw_noise =
          std::hypot(model.yaw_noise_per_sqrt_m * std::sqrt(length),
                     model.yaw_noise_per_sqrt_rad * std::sqrt(kTurnRate * kStepS)) *
          normal(random);
      const Twist2 reported{{(length + noise) / scale / kStepS, 0},
                            (kTurnRate * kStepS + yaw_noise) / turn / kStepS};
      pose = pose * reported.Over(kStepS);
    }
    const auto motion = wheels.Between(0, kStepS * kSteps);
    ASSERT_TRUE(motion);
    const Pose2& T = motion->T_before_now;
    const Eigen::Vector3d error(T.x - truth.x, T.y - truth.y, WrapAngle(T.yaw - truth.yaw));
    nees += error.dot(motion->Covariance().inverse() * error) / kDrives;
  }
  // The travel's noise across is stated, but wheels that roll have none.
  EXPECT_GT(nees, 1.5);
  EXPECT_LT(nees, 3.5);
}

}  // namespace
}  // namespace ceilmap::wheels
