#pragma once

#include <vector>

namespace ceilmap::calibration {

/// How a robot stands that climbs with one end.
struct Climb {
  double pitch_rad = 0;  ///< nose down, by REP-103
  double lift_m = 0;     ///< of the mast's foot
};

/// The line on the floor about which the robot tilts.
struct Pivot {
  double distance_m = 0;  ///< of the mast from it
  /// By leaving out stretches of the recording one after the other (delete-a-group jackknife).
  double sigma_m = 0;
  double rms_m = 0;    ///< of what the lifts are off by
  int frames = 0;      ///< used
  double max_rad = 0;  ///< the steepest of them, > 0
};

/// Pivots of a recording over something on the floor: of a robot whose front climbs the lift of the
/// mast is a sin(pitch up), a being how far the axle is behind the mast; where its rear climbs it
/// is b sin(pitch down), b being how far the front wheels are ahead of it. Lifts above the lines
/// belong to a robot that stands on the thing with its other wheels already; they are left out.
struct PivotFit {
  Pivot axle;          ///< frames 0: the front never climbs
  Pivot front_wheels;  ///< frames 0: the rear never does
};

/// @param climbs  of all frames, in order of time, level ones among them.
PivotFit FitPivots(const std::vector<Climb>& climbs);

}  // namespace ceilmap::calibration
