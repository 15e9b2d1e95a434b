#pragma once

#include <string>
#include <vector>

#include "samples/simulator/gyro.hpp"
#include "samples/simulator/motion_sensors.hpp"
#include "samples/simulator/wheels.hpp"

namespace ceilmap::recordings {

/// odometry.csv: `timestamp,x,y,yaw_deg`, base in the odometry frame, metres and degrees in
/// (-180, 180]; or `timestamp,v,omega`, m/s and rad/s, means since the row before. Stamps in
/// seconds by the wheels' clock.
std::string OdometryText(const std::vector<simulator::WheelSample>& samples,
                         simulator::WheelsKind kind);

/// gyro.csv: `timestamp,omega_z`, rad/s, counter-clockwise positive. Stamps in seconds by the
/// gyro's clock.
std::string GyroText(const std::vector<simulator::GyroSample>& samples);

}  // namespace ceilmap::recordings
