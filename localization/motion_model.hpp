#pragma once

#include <Eigen/Core>
#include <optional>

#include "calib/base/pose_with_covariance.hpp"
#include "calib/base/twist2.hpp"

namespace ceilmap::localization {

struct MotionModelParams {
  /// Change of the robot's speed: growth of the variance of forward and sideways speed per second,
  /// (m/s)^2/s, > 0 ...
  double speed_noise = 0.5;
  double turn_noise = 2.0;  ///< ... and turning speed, (rad/s)^2/s, > 0

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Predicts the pose of a robot: an extended Kalman filter over the pose and the velocity in the
/// base frame, which is constant except for white acceleration (e.g. Bar-Shalom et al. 2001,
/// chapter 6). It needs no wheel odometry. It predicts over gaps of any length; the covariance
/// grows with the gap.
class MotionModel {
 public:
  /// Standard deviations of the speed before any measurement: m/s and rad/s.
  static constexpr double kFirstSpeedSigma = 0.7;
  static constexpr double kFirstTurnSigma = 0.7;
  /// The same of a velocity with which the model is started.
  static constexpr double kStartSpeedSigma = 0.2;
  static constexpr double kStartTurnSigma = 0.3;

  explicit MotionModel(const MotionModelParams& params = {});

  /// Restarts with a measured pose. @param velocity  As measured a moment before; unset: unknown.
  void Start(const PoseWithCovariance& pose,
             double stamp_s,
             const std::optional<Twist2>& velocity = std::nullopt);
  [[nodiscard]] bool Started() const { return started_; }
  void Stop() { started_ = false; }
  [[nodiscard]] double Stamp() const { return stamp_s_; }

  /// The pose at a later time; the state does not change.
  /// @param stamp_s  A time before that of the state is taken as the state's time.
  [[nodiscard]] PoseWithCovariance PredictedAt(double stamp_s) const;
  /// Moves the state to a later time.
  void Predict(double stamp_s);
  /// Updates the state with a measurement of the pose at the state's time. Its error is assumed
  /// independent of earlier measurements.
  void Update(const PoseWithCovariance& measured);
  /// Updates the state with a measurement of the heading alone.
  /// @param variance_rad2  > 0.
  void UpdateYaw(double yaw_rad, double variance_rad2);

  [[nodiscard]] PoseWithCovariance Pose() const;
  /// Forward, sideways (left) and turning speed: m/s, m/s, rad/s.
  [[nodiscard]] Eigen::Vector3d Velocity() const { return state_.tail<3>(); }
  /// Whether the velocity was measured, or given at the start.
  [[nodiscard]] bool KnowsVelocity() const;

 private:
  using State = Eigen::Matrix<double, 6, 1>;
  using Covariance = Eigen::Matrix<double, 6, 6>;

  MotionModelParams params_;
  bool started_ = false;
  double stamp_s_ = 0;
  State state_ = State::Zero();  // x, y, yaw in the map; velocity in the base frame
  Covariance covariance_ = Covariance::Zero();
};

/// Squared Mahalanobis distance of two estimates of the same pose, the errors assumed independent:
/// chi-squared with 3 degrees of freedom.
double SquaredDistance(const PoseWithCovariance& a, const PoseWithCovariance& b);

/// The estimate after a motion: T_map_base * T_base_next, errors independent.
/// @param covariance  Of T_base_next's (x, y, yaw), in the base frame.
PoseWithCovariance Moved(const PoseWithCovariance& pose,
                         const Pose2& T_base_next,
                         const Eigen::Matrix3d& covariance);

}  // namespace ceilmap::localization
