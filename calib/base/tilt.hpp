#pragma once

#include <Eigen/Geometry>

#include "calib/base/pose2.hpp"

namespace ceilmap {

/// Tilt of a robot that is not level, e.g. with debris under its wheels. It is relative to the
/// level base frame with the same foot point and heading, with the signs and the order of REP-103
/// (yaw, then pitch, then roll):
///   p_level = Trans(0, 0, lift) Ry(pitch) Rx(roll) p_base.
struct Tilt {
  double pitch_rad = 0;  ///< > 0: nose down
  double roll_rad = 0;   ///< > 0: left side up
  double lift_m = 0;     ///< of the mast's foot above the floor
  /// Of (pitch, roll), rad^2.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();

  /// True when tilt and lift are exactly zero; the covariance is not considered.
  [[nodiscard]] bool IsLevel() const { return pitch_rad == 0 && roll_rad == 0 && lift_m == 0; }
  [[nodiscard]] Eigen::Isometry3d T_level_base() const;
};

/// Two small angles and their covariance.
struct TiltAngles {
  Eigen::Vector2d angles = Eigen::Vector2d::Zero();  ///< pitch, roll by REP-103, rad
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();

  /// Mahalanobis distance from level, in standard deviations. The covariance must be invertible.
  [[nodiscard]] double Sigmas() const;
};

/// The pose of base in space when its foot point is at a planar pose.
Eigen::Isometry3d ToSpace(const Pose2& T_map_base, const Tilt& tilt);

/// The planar pose and the tilt of a pose in space: the inverse of ToSpace, with zero covariance.
/// Pitch must be within +-90 degrees.
struct PlanarTilt {
  Pose2 pose;
  Tilt tilt;
};
PlanarTilt FromSpace(const Eigen::Isometry3d& T_map_base);

}  // namespace ceilmap
