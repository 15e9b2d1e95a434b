#include "localization/velocity_estimate.hpp"

#include <Eigen/Cholesky>

namespace ceilmap::localization {

namespace {

/// Variance of the change of the velocity from one image to the next.
Eigen::Matrix3d ChangeCovariance() {
  constexpr double kSpeedSigma = 0.3;  // m/s
  constexpr double kTurnSigma = 0.5;   // rad/s
  return Eigen::Vector3d(
             kSpeedSigma * kSpeedSigma, kSpeedSigma * kSpeedSigma, kTurnSigma * kTurnSigma)
      .asDiagonal();
}

}  // namespace

void VelocityEstimate::Start(const std::optional<Twist2>& velocity) {
  velocity_ = velocity;
  covariance_ = ChangeCovariance();
}

void VelocityEstimate::Take(const Pose2& T_before_now,
                            const Eigen::Matrix3d& covariance,
                            double duration_s) {
  const Twist2 measured = Twist2::Mean(T_before_now, duration_s);
  const Eigen::Matrix3d noise = covariance / (duration_s * duration_s);
  if (!velocity_) {
    velocity_ = measured;
    covariance_ = noise;
    return;
  }
  covariance_ += ChangeCovariance();
  const Eigen::Matrix3d gain = (covariance_ + noise).ldlt().solve(covariance_).transpose();
  Eigen::Vector3d innovation;
  innovation << measured.linear_m_s - velocity_->linear_m_s,
      measured.yaw_rad_s - velocity_->yaw_rad_s;
  const Eigen::Vector3d change = gain * innovation;
  velocity_->linear_m_s += change.head<2>();
  velocity_->yaw_rad_s += change.z();
  const Eigen::Matrix3d left = Eigen::Matrix3d::Identity() - gain;
  covariance_ = left * covariance_ * left.transpose() + gain * noise * gain.transpose();
}

PoseWithCovariance VelocityEstimate::MoveOn(double duration_s) {
  covariance_ += ChangeCovariance();
  return {velocity_->Over(duration_s), duration_s * duration_s * covariance_};
}

}  // namespace ceilmap::localization
