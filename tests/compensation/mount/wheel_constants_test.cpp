#include "compensation/mount/wheel_constants.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ceilmap::mount {
namespace {

constexpr double kAxle = 0.12;
constexpr double kDistance = 2.1;  // unit of the solution's lengths
constexpr double kYaw = 1.62;      // of the camera in base

/// The robot's turn in the spin, and its way in the straight drive: even but for start and stop.
double Angle(double t) {
  return 0.5 * (t - std::sin(t));
}
double Way(double t) {
  return 0.2 * (t - std::sin(t));
}

/// A calibration of which all is known: views every 0.5 s over 4 pi s.
UpMount Mount() {
  UpMount mount;
  mount.axle_behind_mast_m.value = kAxle;
  mount.distance_m.value = kDistance;
  mount.solution.mount.yaw_rad = kYaw;
  for (double t = 0; t < 12.6; t += 0.5) {
    mount.solution.spin.push_back({0, 0, WrapAngle(Angle(t))});
    const double rate = 0.5 * (1 - std::cos(t));
    mount.spin_velocities.push_back({t, {{0, kAxle * rate}, rate}});
    // Views have the camera's axes, and base looks to the camera's -yaw.
    const double way = Way(t) / kDistance;
    mount.solution.straight.push_back({way * std::cos(kYaw), -way * std::sin(kYaw), 0});
    mount.straight_velocities.push_back({100 + t, {{0.2 * (1 - std::cos(t)), 0}, 0}});
  }
  return mount;
}

/// @param e, t  recorded travel / true travel - 1; the same of turns.
DriveSensors Sensors(bool spins, double e, double t, double wheels_late_s, double bias_rad_s) {
  DriveSensors sensors;
  sensors.wheels = wheels::DeadReckoning({}, kAxle);
  const double first_s = spins ? 0 : 100;
  for (double s = -1; s < 14; s += 0.02) {
    const double yaw = spins ? (1 + t) * Angle(s) : 0;
    const double way = spins ? 0 : (1 + e) * Way(s);
    const Pose2 T_odom_axle{way, 0, yaw};
    sensors.wheels.Add(
        wheels::OdometrySample{first_s + s + wheels_late_s, T_odom_axle * Pose2{kAxle, 0, 0}});
    const double rate = spins ? 0.5 * (1 - std::cos(s)) : 0;
    sensors.gyro.Add(wheels::GyroSample{first_s + s, rate + bias_rad_s});
  }
  return sensors;
}

void ExpectFound(const wheels::Uncertain& found, double truth, double within) {
  EXPECT_NEAR(found.value, truth, within);
  EXPECT_NEAR(found.value, truth, 3 * found.sigma);
}

TEST(WheelConstants, SpinAndDriveShowAllOfThem) {
  const WheelConstants found = MeasureWheelConstants(Mount(),
                                                     Sensors(true, 0.02, -0.03, 0.02, 0.005),
                                                     Sensors(false, 0.02, -0.03, 0.02, 0.005),
                                                     {});
  ExpectFound(found.model.scale, 1 / 1.02, 3e-3);
  ExpectFound(found.model.turn_scale, 1 / 0.97, 3e-3);
  ExpectFound(found.model.late_s, 0.02, 2e-3);
  ExpectFound(found.model.gyro_bias_rad_s, 0.005, 2e-4);
  ExpectFound(found.model.gyro_late_s, 0, 1e-3);
  EXPECT_LT(found.model.gyro_bias_rad_s.sigma, 5e-4);
  EXPECT_LT(found.model.turn_scale.sigma, 0.01);
  EXPECT_EQ(found.wheels.both.slips + found.gyro.both.slips, 0);
  for (const SensorAgreement& sensor : {found.wheels, found.gyro}) {
    EXPECT_GT(sensor.spin.pieces, 10);
    EXPECT_GT(sensor.straight.pieces, 10);
    EXPECT_EQ(sensor.both.pieces, sensor.spin.pieces + sensor.straight.pieces);
  }
}

TEST(WheelConstants, WhatWasNotRecordedStays) {
  const wheels::WheelModel before;
  DriveSensors spin = Sensors(true, 0, 0, 0, 0.005);
  spin.wheels = wheels::DeadReckoning();
  const DriveSensors nothing;
  const WheelConstants found = MeasureWheelConstants(Mount(), spin, nothing, before);
  EXPECT_EQ(found.wheels.both.pieces, 0);
  EXPECT_EQ(found.gyro.straight.pieces, 0);
  EXPECT_EQ(found.model.scale.sigma, before.scale.sigma);
  EXPECT_EQ(found.model.turn_scale.value, before.turn_scale.value);
  ExpectFound(found.model.gyro_bias_rad_s, 0.005, 3e-4);
}

TEST(WheelConstants, ARecordingOfAnotherDriveIsToldApart) {
  const DriveSensors spin = Sensors(true, 0, 0, 0, 0);
  DriveSensors other = Sensors(false, 0, 0, 0, 0);
  other.wheels = wheels::DeadReckoning({}, kAxle);
  for (double s = -1; s < 14; s += 0.02) {
    other.wheels.Add(wheels::WheelSpeedSample{100 + s, {{-0.3, 0}, 0}});
  }
  const WheelConstants found = MeasureWheelConstants(Mount(), spin, other, {});
  EXPECT_EQ(found.wheels.spin.slips, 0);
  EXPECT_GT(2 * found.wheels.straight.slips, found.wheels.straight.pieces);
  EXPECT_EQ(found.gyro.straight.slips, 0);
}

}  // namespace
}  // namespace ceilmap::mount
