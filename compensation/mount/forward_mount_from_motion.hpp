#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <string>
#include <vector>

#include "calib/rig.hpp"
#include "calib/solve/forward_mount.hpp"
#include "compensation/mount/measured.hpp"
#include "compensation/mount/up_mount.hpp"

namespace ceilmap::mount {

/// Direction of a forward camera, relative to a level camera that points along base x:
/// p_base = Rz(yaw) Ry(-pitch) Rx(roll) p_level. Pitch > 0 is raised.
struct ForwardAngles {
  double yaw_rad = 0;
  double pitch_rad = 0;
  double roll_rad = 0;
};
/// @param R_base_cam  of the optical frame.
ForwardAngles ForwardAnglesOf(const Eigen::Matrix3d& R_base_cam);

/// The mount of the forward camera. An angle that the recordings do not determine has a large
/// deviation and stays near its initial value.
struct ForwardMount {
  Measured yaw_rad;
  Measured pitch_rad;
  Measured roll_rad;
  Eigen::Isometry3d T_base_forward = Eigen::Isometry3d::Identity();
  calibration::ForwardMount solution;
  std::size_t pairs = 0;  ///< of images
};

/// Determines the direction of the forward camera from its images while the robot turns on the spot
/// and drives straight ahead (calib/solve/forward_mount.hpp).
///
/// @param forward  intrinsics and position as measured, which stay; the direction is the initial
///   value, with an error of at most some 10 degrees.
/// @param motions  of one recording after the other (ForwardFeatureTracker), with the robot's
///   motion by the upward camera as calibrated.
/// @param up  mount of the upward camera, whose deviations are part of the result's.
/// @param lens_sigma_px  see MeasureUpMount.
/// @param name  of the recordings, for messages.
/// @throws InputError with the name when there are too few matches, or they do not agree.
ForwardMount MeasureForwardMount(const calib::MountedCamera& forward,
                                 const std::vector<calibration::MotionWithMatches>& motions,
                                 const UpMount& up,
                                 double lens_sigma_px,
                                 const std::string& name);

}  // namespace ceilmap::mount
