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
  /// As the file spells it: of unit length only up to its rounding.
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// A robot whose foot stands at a planar pose, level on the floor unless it is tilted.
StampedPose ToStampedPose(double stamp_s, const Pose2& T_map_base, const Tilt& tilt = {});

/// Turn about the vertical in (-pi, pi], counter-clockwise seen from above (z-y-x Euler angles).
double YawOf(const StampedPose& pose);
/// The other two of these angles by REP-103: pitch in [-pi/2, pi/2], > 0 with the nose down; roll
/// in (-pi, pi], > 0 with the left side up.
double PitchOf(const StampedPose& pose);
double RollOf(const StampedPose& pose);

/// Where it stands on the floor, and its yaw.
Pose2 PlanarPose(const StampedPose& pose);

/// Length of the way over the floor from the first pose to each, in metres.
std::vector<double> PathLengths(const std::vector<StampedPose>& poses);

}  // namespace ceilmap
