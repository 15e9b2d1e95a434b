#include "localization/compass/wheel_turns.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calib/base/degrees.hpp"

namespace ceilmap::compass {
namespace {

using wheels::WheelFault;

double TurnRate(double stamp_s) {
  return 0.5 * std::sin(0.4 * stamp_s);
}
double Heading(double stamp_s) {
  return 0.5 / 0.4 * (1 - std::cos(0.4 * stamp_s));
}

/// What a compass is told, and tells, on a drive of 60 s with panoramas at 10 Hz.
struct WheelDrive {
  double sign = 1;  // of the reported turns
  double bias_rad_s = 0.01;
  bool gyro = true;

  /// @param each  takes the stamp and the completed frame.
  template <typename Each>
  void Run(WheelTurns& turns, Each each) const {
    std::mt19937 random(4);
    std::normal_distribution<double> normal(0, 0.001);
    int sample = 0;
    for (int i = 0; i <= 600; ++i) {
      const double stamp_s = 0.1 * i;
      for (; 0.02 * sample <= stamp_s + 0.1; ++sample) {
        const double at_s = 0.02 * sample;
        if (gyro) {
          turns.Add(wheels::GyroSample{at_s, sign * TurnRate(at_s) + bias_rad_s});
        } else {
          turns.Add(wheels::WheelSpeedSample{at_s, {{0.4, 0}, sign * TurnRate(at_s - 0.01)}});
        }
      }
      PanoramaFrame frame;
      frame.stamp_s = stamp_s;
      turns.Complete(frame);
      each(stamp_s, frame);
      HeadingEstimate estimate;
      estimate.seen = HeadingPrior{WrapAngle(Heading(stamp_s) + normal(random)), 1e-6};
      turns.Learn(stamp_s, estimate);
    }
  }
};

TEST(WheelTurns, AGyroIsEnoughForTurnsAndItsBiasIsFound) {
  WheelTurns turns;
  WheelDrive().Run(turns, [](double stamp_s, const PanoramaFrame& frame) {
    EXPECT_FALSE(frame.travel);
    EXPECT_EQ(frame.turn.has_value(), stamp_s > 0);
    if (stamp_s < 40) return;
    const double turn = Heading(stamp_s) - Heading(stamp_s - 0.1);
    EXPECT_NEAR(frame.turn->turn_rad, turn, 2e-4);
    EXPECT_FALSE(frame.turn->may_slip);
  });
  const wheels::WheelsReport report = turns.Report();
  const wheels::Uncertain bias = report.model.gyro_bias_rad_s;
  EXPECT_NEAR(bias.value, 0.01, 3 * bias.sigma);
  EXPECT_LT(bias.sigma, 0.001);
  EXPECT_EQ(report.missing, 0);
  EXPECT_EQ(report.slips, 0);
  EXPECT_EQ(report.fault, WheelFault::kNone);
  // Travel was not seen: its noise stays as stated.
  EXPECT_EQ(report.model.travel_noise_per_sqrt_m, wheels::WheelModel().travel_noise_per_sqrt_m);
}

TEST(WheelTurns, WheelsTellTravelOfTheCameraToo) {
  const Eigen::Vector2d camera(0.2, 0.1);
  WheelTurns turns({}, 0, camera);
  WheelDrive drive;
  drive.gyro = false;
  drive.Run(turns, [&](double stamp_s, const PanoramaFrame& frame) {
    EXPECT_EQ(frame.travel.has_value(), stamp_s > 0);
    if (stamp_s < 40) return;
    const double turn = Heading(stamp_s) - Heading(stamp_s - 0.1);
    EXPECT_TRUE(frame.turn->may_slip);
    EXPECT_NEAR(frame.turn->turn_rad, turn, 3e-3);
    EXPECT_NEAR(frame.travel->x(), 0.04 - camera.y() * turn, 1e-3);
    EXPECT_NEAR(frame.travel->y(), 0.5 * 0.04 * -turn + camera.x() * turn + 0.04 * turn, 3e-3);
  });
  EXPECT_NEAR(turns.Report().model.turn_scale.value, 1, 0.01);
  EXPECT_EQ(turns.Report().fault, WheelFault::kNone);
}

TEST(WheelTurns, ATurnIsNotBelievedBeforeItAgreedWithPanoramas) {
  WheelTurns turns;
  WheelDrive().Run(turns, [](double stamp_s, const PanoramaFrame& frame) {
    if (stamp_s == 0) return;
    const double common = frame.turn->common_rad;
    if (stamp_s < 2) {
      EXPECT_GE(common, std::abs(frame.turn->turn_rad));
    } else if (stamp_s > 20) {
      EXPECT_LT(common, 2e-4);
    }
  });
}

TEST(WheelTurns, TheOppositeSignIsFoundAndNotUsed) {
  for (const bool gyro : {false, true}) {
    WheelTurns turns;
    WheelDrive drive;
    drive.sign = -1;
    drive.gyro = gyro;
    drive.Run(turns, [](double stamp_s, const PanoramaFrame& frame) {
      if (frame.turn) {
        EXPECT_GE(frame.turn->common_rad, std::abs(frame.turn->turn_rad));
      }
      EXPECT_TRUE(stamp_s == 0 || frame.turn || stamp_s > 5);
      EXPECT_FALSE(frame.turn && stamp_s > 30);
    });
    EXPECT_EQ(turns.Report().fault, WheelFault::kOppositeYaw);
  }
}

TEST(WheelTurns, DegreesInsteadOfRadiansAreNamed) {
  WheelTurns turns;
  WheelDrive drive;
  drive.sign = kDegPerRad;
  drive.gyro = true;
  drive.Run(turns, [](double /*stamp_s*/, const PanoramaFrame& /*frame*/) {});
  EXPECT_EQ(turns.Report().fault, WheelFault::kTurnUnits);
}

TEST(WheelTurns, AGapIsCounted) {
  WheelTurns turns;
  for (int i = 0; i < 200; ++i) {
    if (i > 50 && i < 150) continue;
    turns.Add(wheels::GyroSample{0.02 * i, 0});
  }
  for (int i = 0; i < 40; ++i) {
    PanoramaFrame frame;
    frame.stamp_s = 0.1 * i;
    turns.Complete(frame);
    const bool gap = frame.stamp_s > 0.99 && frame.stamp_s < 3.09;
    EXPECT_EQ(frame.turn.has_value(), i > 0 && !gap) << i;
  }
  EXPECT_EQ(turns.Report().missing, 21);
}

}  // namespace
}  // namespace ceilmap::compass
