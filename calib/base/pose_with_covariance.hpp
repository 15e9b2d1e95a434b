#pragma once

#include <Eigen/Core>

#include "calib/base/pose2.hpp"

namespace ceilmap {

/// A planar pose and how well it is known.
struct PoseWithCovariance {
  Pose2 pose;
  /// Of (x, y, yaw) in the pose's parent frame; m^2, m rad, rad^2 (pixels for metres without a
  /// rig).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Covariance of T_a_c = T_a_b * T_b_c, first order, from those of the factors' (x, y, yaw), taken
/// as independent.
Eigen::Matrix3d ComposeCovariance(const Pose2& T_a_b,
                                  const Eigen::Matrix3d& cov_a_b,
                                  const Pose2& T_b_c,
                                  const Eigen::Matrix3d& cov_b_c);

/// The part `factor` of a motion at constant forward, sideways and turning speed; factor may exceed
/// 1 or be negative (prediction). |yaw| of the motion below pi.
Pose2 Interpolate(const Pose2& T_a_b, double factor);

}  // namespace ceilmap
