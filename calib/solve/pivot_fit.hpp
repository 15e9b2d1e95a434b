#pragma once

#include <vector>

namespace ceilmap::calibration {

/// Pose of a robot that climbs with one end.
struct Climb {
  double pitch_rad = 0;  ///< nose down, by REP-103
  double lift_m = 0;     ///< of the mast's foot
};

/// The line on the floor about which the robot tilts.
struct Pivot {
  double distance_m = 0;  ///< of the mast from it
  /// From a delete-a-group jackknife over intervals of the recording.
  double sigma_m = 0;
  double rms_m = 0;    ///< of the residuals of the lifts
  int frames = 0;      ///< number of used frames
  double max_rad = 0;  ///< largest of their pitches, > 0
};

/// Pivots of a recording over an obstacle on the floor. If the front climbs, the lift of the mast
/// is a sin(pitch up), where a is the distance of the axle behind the mast; if the rear climbs, it
/// is b sin(pitch down), where b is the distance of the front wheels ahead of the mast. Larger
/// lifts belong to a robot whose other wheels are on the obstacle too; they are left out.
struct PivotFit {
  Pivot axle;          ///< frames 0: the front never climbs
  Pivot front_wheels;  ///< frames 0: the rear never does
};

/// @param climbs  Of all frames, in order of time, including level ones.
PivotFit FitPivots(const std::vector<Climb>& climbs);

}  // namespace ceilmap::calibration
