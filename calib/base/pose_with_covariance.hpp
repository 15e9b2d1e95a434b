#pragma once

#include <Eigen/Core>

#include "calib/base/pose2.hpp"

namespace ceilmap {

/// A planar pose and its uncertainty.
struct PoseWithCovariance {
  Pose2 pose;
  /// Of (x, y, yaw) in the pose's parent frame; m^2, m rad, rad^2 (pixels for metres without a
  /// rig).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Covariance of T_a_c = T_a_b * T_b_c to first order, from the covariances of (x, y, yaw) of the
/// two factors, which are assumed to be independent.
Eigen::Matrix3d ComposeCovariance(const Pose2& T_a_b,
                                  const Eigen::Matrix3d& cov_a_b,
                                  const Pose2& T_b_c,
                                  const Eigen::Matrix3d& cov_b_c);

/// The mean of two independent estimates of one pose, weighted by their information. At least one
/// of the covariances must be positive definite.
PoseWithCovariance Fused(const PoseWithCovariance& a, const PoseWithCovariance& b);

/// The fraction `factor` of a motion at constant forward, lateral and angular velocity. The factor
/// may exceed 1 or be negative (prediction). |yaw| of the motion must be below pi.
Pose2 Interpolate(const Pose2& T_a_b, double factor);

}  // namespace ceilmap
