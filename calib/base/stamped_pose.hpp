#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/base/tilt.hpp"

namespace ceilmap {

/// One line of a trajectory file: the pose of base in the map, p_map = orientation * p_base +
/// position.
struct StampedPose {
  double stamp_s = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< metres (pixels without a rig)
  /// As read from the file: of unit length up to the rounding in the file.
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// The pose of a robot whose foot point is at a planar pose; it is level on the floor unless a tilt
/// is given.
StampedPose ToStampedPose(double stamp_s, const Pose2& T_map_base, const Tilt& tilt = {});

/// Rotation about the vertical in (-pi, pi], counter-clockwise seen from above (z-y-x Euler
/// angles).
double YawOf(const StampedPose& pose);
/// The other two of these angles by REP-103: pitch in [-pi/2, pi/2], > 0 with the nose down; roll
/// in (-pi, pi], > 0 with the left side up.
double PitchOf(const StampedPose& pose);
double RollOf(const StampedPose& pose);

/// Position on the floor, and yaw.
Pose2 PlanarPose(const StampedPose& pose);

/// Distance travelled over the floor from the first pose to each pose, in metres.
std::vector<double> PathLengths(const std::vector<StampedPose>& poses);

}  // namespace ceilmap
