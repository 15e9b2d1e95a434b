#pragma once

#include <Eigen/Core>
#include <optional>

#include "calib/base/pose_with_covariance.hpp"
#include "calib/wheels/wheel_model.hpp"

namespace ceilmap::wheels {

/// A motion of the robot as its wheels and gyro tell it: T_before_now, and its errors. Independent
/// errors of the steps add up as variances. Errors that all steps have in common, of the scale and
/// of the turn, add up as lengths. Slips displace the robot by as much as those that were seen, in
/// any direction.
struct RelativeMotion {
  Pose2 T_before_now;
  /// Covariance of (x, y, yaw) by noise, in the axes of `before`.
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  /// Errors of (x, y, yaw) for one standard deviation of the scale, and of the turn scale or the
  /// gyro's bias.
  Eigen::Matrix<double, 3, 2> common = Eigen::Matrix<double, 3, 2>::Zero();
  double travel_m = 0;  ///< length of the way
  SlipRate slips;       ///< of the wheels, as far as it was known at the end of the motion

  /// Of all.
  [[nodiscard]] Eigen::Matrix3d Covariance() const;
  /// Where the robot is after this motion from a pose whose errors are independent of it.
  [[nodiscard]] PoseWithCovariance From(const PoseWithCovariance& before) const;
  /// Where it was before this motion led to a pose, likewise.
  [[nodiscard]] PoseWithCovariance Back(const PoseWithCovariance& now) const;
};

/// A turn of the robot as a gyro or its wheels tell it, with its errors as those of a
/// RelativeMotion.
struct RelativeTurn {
  double turn_rad = 0;    ///< counter-clockwise seen from above, not wrapped
  double noise_rad2 = 0;  ///< variance by noise
  double common_rad = 0;  ///< error for one standard deviation of the turn scale or the bias
  bool may_slip = true;   ///< false: all of it is measured by a gyro

  [[nodiscard]] double Variance() const { return noise_rad2 + common_rad * common_rad; }
};

/// The turn a, then b.
RelativeTurn operator+(const RelativeTurn& a, const RelativeTurn& b);

/// Whether a pose that only wheels predict says more than that the robot is in the building: its
/// standard deviation is below 2 m and 0.8 rad.
bool IsUsable(const PoseWithCovariance& predicted);

/// The motion a, then b.
RelativeMotion operator*(const RelativeMotion& a, const RelativeMotion& b);
/// The same of motions that may not be known; nothing where one of them is not.
std::optional<RelativeMotion> Joined(const std::optional<RelativeMotion>& a,
                                     const std::optional<RelativeMotion>& b);

}  // namespace ceilmap::wheels
