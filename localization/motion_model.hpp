#pragma once

#include <Eigen/Core>

#include "calib/base/pose2.hpp"

namespace ceilmap::localization {

/// A pose and how far it can be trusted.
struct PoseEstimate {
  Pose2 T_map_base;
  /// Of (x, y, yaw) in the map frame; m^2, m rad, rad^2.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

struct MotionModelParams {
  /// How much the robot's speed changes: variance that forward and sideways speed gain in a second,
  /// (m/s)^2/s, > 0 ...
  double speed_noise = 0.5;
  double turn_noise = 2.0;  ///< ... and turning speed, (rad/s)^2/s, > 0
  /// What is known of the speed before anything was measured: m/s and rad/s, > 0.
  double first_speed_sigma = 0.7;
  double first_turn_sigma = 0.7;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Where a robot will be, from where it was: an extended Kalman filter over the pose and the body's
/// velocity, which is constant but for white accelerations (e.g. Bar-Shalom et al. 2001, chapter
/// 6). No wheels are needed; it predicts over gaps of any length, with a covariance that tells how
/// little is known after them.
class MotionModel {
 public:
  explicit MotionModel(const MotionModelParams& params = {});

  /// Begins anew with a measured pose, its speed unknown.
  void Start(const PoseEstimate& pose, double stamp_s);
  [[nodiscard]] bool Started() const { return started_; }
  void Stop() { started_ = false; }
  [[nodiscard]] double Stamp() const { return stamp_s_; }

  /// The pose at a later moment; the state stays. @param stamp_s  a moment before the last one
  /// counts as that one.
  [[nodiscard]] PoseEstimate PredictedAt(double stamp_s) const;
  /// Moves the state to a later moment.
  void Predict(double stamp_s);
  /// Takes a measurement of the pose at the state's moment. The errors are taken as independent of
  /// what was measured before.
  void Update(const PoseEstimate& measured);
  /// Takes a measurement of the heading alone. @param variance_rad2  > 0.
  void UpdateYaw(double yaw_rad, double variance_rad2);

  [[nodiscard]] PoseEstimate Pose() const;
  /// Forward, sideways (left) and turning speed: m/s, m/s, rad/s.
  [[nodiscard]] Eigen::Vector3d Velocity() const { return state_.tail<3>(); }

 private:
  using State = Eigen::Matrix<double, 6, 1>;
  using Covariance = Eigen::Matrix<double, 6, 6>;

  MotionModelParams params_;
  bool started_ = false;
  double stamp_s_ = 0;
  State state_ = State::Zero();  // x, y, yaw in the map; velocity in the base frame
  Covariance covariance_ = Covariance::Zero();
};

/// Squared distance of two estimates of the same pose in standard deviations of their difference
/// (Mahalanobis), the errors taken as independent: chi-squared with 3 degrees of freedom.
double SquaredDistance(const PoseEstimate& a, const PoseEstimate& b);

/// The estimate after a motion: T_map_base * T_base_next, errors independent. @param covariance  of
/// T_base_next's (x, y, yaw), in the base frame.
PoseEstimate Moved(const PoseEstimate& pose,
                   const Pose2& T_base_next,
                   const Eigen::Matrix3d& covariance);

}  // namespace ceilmap::localization
