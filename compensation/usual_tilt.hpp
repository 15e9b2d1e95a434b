#pragma once

#include "calib/base/tilt.hpp"

namespace ceilmap::compensation {

/// What to expect of the tilt of a frame that no camera measured: the mean square of the tilts that
/// were measured. Of a robot whose tilt was never measured it is (0.35 degrees)^2: most robots
/// stand on debris, to 2 degrees, for some percent of their way.
class UsualTilt {
 public:
  /// A tilt that was measured. The latest 500 count most.
  void Add(const Eigen::Vector2d& pitch_roll_rad);

  /// The prediction, which means nothing after a moment, combined with the usual tilt, which is
  /// small where the robot drives on a clean floor. A robot that was tilted may still be.
  [[nodiscard]] TiltAngles Combine(const TiltAngles& predicted) const;

 private:
  static constexpr double kUnmeasuredSigmaRad = 0.006;
  static constexpr int kUnmeasuredFrames = 30;  // measured frames that it counts as

  double variance_ = kUnmeasuredSigmaRad * kUnmeasuredSigmaRad;  // of each angle, rad^2
  int frames_ = kUnmeasuredFrames;
};

}  // namespace ceilmap::compensation
