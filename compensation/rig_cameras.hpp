#pragma once

#include <Eigen/Core>
#include <cmath>

#include "calib/base/error.hpp"
#include "calib/base/tilt.hpp"
#include "calib/rig.hpp"

namespace ceilmap::compensation {

/// @throws InputError when the rig has no upward camera.
inline const calib::MountedCamera& UpOf(const calib::Rig& rig) {
  if (!rig.up) throw InputError("the rig has no camera 'up'; add it under cameras");
  return *rig.up;
}

/// @throws InputError when the rig has no forward camera.
inline const calib::MountedCamera& ForwardOf(const calib::Rig& rig) {
  if (!rig.forward) throw InputError("the rig has no camera 'forward'; add it under cameras");
  return *rig.forward;
}

/// `d`: height of the forward camera above the floor. @throws InputError as ForwardOf.
inline double ForwardHeight(const calib::Rig& rig) {
  return rig.forward_height_m.value_or(ForwardOf(rig).T_base_cam.translation().z());
}

/// Pitch and roll about the axes of base, from those about the axes across and along the view of
/// the forward camera. Both are small rotations about horizontal axes.
/// @param camera_yaw_rad  Direction of the view, from the x axis of base.
/// @param angles  Pitch and roll of the view. @param variances  Of them.
inline TiltAngles InAxesOfBase(double camera_yaw_rad,
                               const Eigen::Vector2d& angles,
                               const Eigen::Vector2d& variances) {
  const double c = std::cos(camera_yaw_rad);
  const double s = std::sin(camera_yaw_rad);
  Eigen::Matrix2d turn;
  turn << c, s, -s, c;
  return {turn * angles, turn * variances.asDiagonal() * turn.transpose()};
}

}  // namespace ceilmap::compensation
