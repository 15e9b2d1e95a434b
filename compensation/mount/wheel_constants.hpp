#pragma once

#include <cstdint>

#include "calib/wheels/wheels_report.hpp"
#include "compensation/mount/up_mount.hpp"

namespace ceilmap::mount {

/// Wheels and gyro during a recording of the calibration, apart from each other, so that each is
/// compared with the ceiling by itself; the wheels with the distance of the axle as measured.
/// Either may be empty. Longest recording: two minutes.
struct DriveSensors {
  wheels::DeadReckoning wheels;
  wheels::DeadReckoning gyro;
};

/// Pieces of the way of a recording that were compared with the ceiling.
struct ComparedPieces {
  std::int64_t pieces = 0;
  std::int64_t slips = 0;  ///< of these, that contradict it
};

/// How a sensor agrees with the ceiling.
struct SensorAgreement {
  ComparedPieces spin;
  ComparedPieces straight;
  wheels::WheelsReport both;
};

/// The constants of wheels and gyro, as the recordings of a calibration show them.
struct WheelConstants {
  wheels::WheelModel model;  ///< of both; what was not shown is as before
  SensorAgreement wheels;
  SensorAgreement gyro;
};

/// Compares the robot's motion in a spin and a straight drive, as the ceiling shows it, with that
/// by wheels and gyro (wheels::WheelCalibrator): scale and delay by the drive, turn scale, gyro
/// bias and delays by the spin.
/// @param mount  of recordings with stamps.
/// @param first  what is known before.
WheelConstants MeasureWheelConstants(const UpMount& mount,
                                     const DriveSensors& spin,
                                     const DriveSensors& straight,
                                     const wheels::WheelModel& first);

}  // namespace ceilmap::mount
