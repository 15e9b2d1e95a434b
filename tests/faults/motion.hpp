#pragma once

#include <string>
#include <vector>

#include "samples/simulator/gyro.hpp"
#include "samples/simulator/wheels.hpp"
#include "tests/faults/recording.hpp"

namespace ceilmap::faults {

/// What a robot's wheels and gyro record during a drive; empty without them.
struct Motion {
  std::vector<simulator::WheelSample> wheels;
  std::vector<simulator::GyroSample> gyro;
};

/// The motion of the scene's drive until its last image.
Motion RecordMotion(const simulator::Scene& scene, const Recording& shots);

/// How odometry is stored.
enum class OdometryForm {
  kSpeeds,  ///< CSV, timestamp,v,omega
  kTum      ///< poses as lines of TUM
};

std::string OdometryText(const Motion& motion, OdometryForm form);
/// CSV, timestamp,omega_z.
std::string GyroText(const Motion& motion);

}  // namespace ceilmap::faults
