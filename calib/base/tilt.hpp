#pragma once

#include <Eigen/Geometry>

#include "calib/base/pose2.hpp"

namespace ceilmap {

/// How a robot stands that is not level: debris under its wheels. Relative to the level base frame
/// with the same foot point and heading, by REP-103's signs and order (yaw, then pitch, then roll):
///   p_level = Trans(0, 0, lift) Ry(pitch) Rx(roll) p_base.
struct Tilt {
  double pitch_rad = 0;  ///< > 0: nose down
  double roll_rad = 0;   ///< > 0: left side up
  double lift_m = 0;     ///< of the mast's foot above the floor
  /// Of (pitch, roll), rad^2.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();

  /// No tilt and no lift at all; what the covariance says does not matter.
  [[nodiscard]] bool IsLevel() const { return pitch_rad == 0 && roll_rad == 0 && lift_m == 0; }
  [[nodiscard]] Eigen::Isometry3d T_level_base() const;
};

/// Two small angles and how well they are known.
struct TiltAngles {
  Eigen::Vector2d angles = Eigen::Vector2d::Zero();  ///< pitch, roll by REP-103, rad
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();

  /// How far from level, in standard deviations. The covariance must be invertible.
  [[nodiscard]] double Sigmas() const;
};

/// The pose of base in space whose foot stands at a planar pose.
Eigen::Isometry3d ToSpace(const Pose2& T_map_base, const Tilt& tilt);

/// The planar pose and the tilt of a pose in space: the inverse of ToSpace, the covariance left at
/// zero. Pitch must be within +-90 degrees.
struct PlanarTilt {
  Pose2 pose;
  Tilt tilt;
};
PlanarTilt FromSpace(const Eigen::Isometry3d& T_map_base);

}  // namespace ceilmap
