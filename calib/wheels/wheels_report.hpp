#pragma once

#include <cstdint>

#include "calib/wheels/dead_reckoning.hpp"
#include "calib/wheels/wheel_calibrator.hpp"

namespace ceilmap::wheels {

/// What wheels and gyro contributed to a run.
struct WheelsReport {
  WheelsReport() = default;
  /// @param missing_frames  as `missing`.
  WheelsReport(const DeadReckoning& reckoning,
               const WheelCalibrator& calibrator,
               std::int64_t missing_frames);

  std::int64_t samples = 0;  ///< of the wheels
  bool gyro = false;
  double gyro_stuck_s = 0;   ///< for how long the gyro repeated one value (DeadReckoning)
  std::int64_t missing = 0;  ///< frames whose motion the sensors do not tell
  /// As estimated in the run. What the drive did not show has the values and standard deviations
  /// of the rig, or the defaults.
  WheelModel model;
  std::int64_t pieces = 0;  ///< of the way, that were compared with images
  std::int64_t slips = 0;   ///< of these, that contradict them
  /// Not kNone: the odometry was not used from then on.
  WheelFault fault = WheelFault::kNone;
  double travel_ratio = 0;  ///< seen / reported, with a fault; 0: not known
  double turn_ratio = 0;
};

}  // namespace ceilmap::wheels
