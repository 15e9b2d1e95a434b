#pragma once

#include <Eigen/Core>
#include <optional>

#include "calib/base/twist2.hpp"
#include "localization/motion_model.hpp"

namespace ceilmap::localization {

/// Velocity of a robot by the steps that were measured: a Kalman filter of constant velocity in the
/// axes of base. A step that is measured badly changes it little.
class VelocityEstimate {
 public:
  void Forget() { velocity_.reset(); }
  /// @param velocity  as known from elsewhere; nothing: not known.
  void Start(const std::optional<Twist2>& velocity);

  [[nodiscard]] bool IsKnown() const { return velocity_.has_value(); }
  [[nodiscard]] const std::optional<Twist2>& Velocity() const { return velocity_; }

  /// Takes a measured step. @param covariance  of its (x, y, yaw) in the axes of base, m and rad.
  /// @param duration_s  > 0.
  void Take(const Pose2& T_before_now, const Eigen::Matrix3d& covariance, double duration_s);
  /// The next step of a robot that moves on as before, as far as its velocity is known and may have
  /// changed since. Each call is one image later: the velocity becomes less certain. Only where it
  /// is known (IsKnown).
  PoseWithCovariance MoveOn(double duration_s);

 private:
  std::optional<Twist2> velocity_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();  // of its m/s, m/s, rad/s
};

}  // namespace ceilmap::localization
