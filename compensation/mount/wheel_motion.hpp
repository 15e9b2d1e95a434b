#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calib/base/stamped_pose.hpp"
#include "compensation/mount/measured.hpp"

namespace ceilmap::mount {

/// Motion of the levelled upward camera from one keyframe to the next.
struct DriveStep {
  double start_s = 0;
  double end_s = 0;
  /// In the camera's axes at the mean of both headings, in units of the ceiling's distance.
  Eigen::Vector2d moved = Eigen::Vector2d::Zero();
  double turn_rad = 0;
};

/// The mount of the camera relative to driven wheels, which do not slip sideways: the middle of the
/// axle moves along base x, except for errors of the wheels.
struct WheelMotion {
  Measured yaw_rad;  ///< of the levelled camera in base
  Measured ahead;    ///< x of the camera relative to the axle, in units of the ceiling's distance
  double slip = 0;   ///< sideways, robust standard deviation relative to the steps' length
};

/// The direction in which the robot drives most is taken as ahead.
/// @return nothing when there are fewer than 5 steps.
std::optional<WheelMotion> FitWheels(const std::vector<DriveStep>& steps);

/// The camera compared with a trajectory of the same drive.
struct OdometryFit {
  bool mirrored = false;  ///< the camera turns right where the odometry turns left
  /// How much the images' stamps are later than the odometry's; needs changes of the turn rate.
  std::optional<Measured> late_s;
  Measured distance_m;  ///< from the camera to the ceiling
  Measured yaw_rad;     ///< of the levelled camera in base
};

/// @param odometry  of base or of any point that is fixed to the robot; stamps increase.
/// @return nothing when fewer than 5 steps lie in its time, or the robot turns by less than 60 deg.
std::optional<OdometryFit> FitOdometry(const std::vector<DriveStep>& steps,
                                       const std::vector<StampedPose>& odometry);

}  // namespace ceilmap::mount
