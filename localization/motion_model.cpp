#include "localization/motion_model.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"
#include "calib/base/pose_with_covariance.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::localization {

void MotionModelParams::Validate() const {
  const auto require_positive = [](const char* field, double value) {
    if (value > 0 && std::isfinite(value)) return;
    throw InputError(fmt::format("motion model: {} = {}, must be > 0", field, value));
  };
  require_positive("speed_noise", speed_noise);
  require_positive("turn_noise", turn_noise);
}

MotionModel::MotionModel(const MotionModelParams& params) : params_(params) {
  params_.Validate();
}

void MotionModel::Start(const PoseWithCovariance& pose,
                        double stamp_s,
                        const std::optional<Twist2>& velocity) {
  started_ = true;
  stamp_s_ = stamp_s;
  const Twist2 known = velocity.value_or(Twist2{});
  state_ << pose.pose.x, pose.pose.y, pose.pose.yaw, known.linear_m_s, known.yaw_rad_s;
  covariance_.setZero();
  covariance_.topLeftCorner<3, 3>() = pose.covariance;
  const double speed = velocity ? kStartSpeedSigma : kFirstSpeedSigma;
  const double turn = velocity ? kStartTurnSigma : kFirstTurnSigma;
  covariance_.diagonal().tail<3>() << speed * speed, speed * speed, turn * turn;
}

bool MotionModel::KnowsVelocity() const {
  // Of the first standard deviations: also known at three frames a second, where the turning speed
  // of a tracked robot has 0.63 of its first one.
  constexpr double kKnownRatio = 0.7;
  const Eigen::Array3d sigma = covariance_.diagonal().tail<3>().array().sqrt();
  const Eigen::Array3d first(kFirstSpeedSigma, kFirstSpeedSigma, kFirstTurnSigma);
  return started_ && (sigma < kKnownRatio * first).all();
}

PoseWithCovariance MotionModel::PredictedAt(double stamp_s) const {
  MotionModel later = *this;
  later.Predict(stamp_s);
  return later.Pose();
}

void MotionModel::Predict(double stamp_s) {
  const double dt = stamp_s - stamp_s_;
  if (!(dt > 0)) return;
  stamp_s_ = stamp_s;
  // Moves along the chord: heading at the middle of the step.
  const double middle = state_[2] + 0.5 * dt * state_[5];
  const double c = std::cos(middle);
  const double s = std::sin(middle);
  const double step_x = dt * (c * state_[3] - s * state_[4]);
  const double step_y = dt * (s * state_[3] + c * state_[4]);
  Covariance F = Covariance::Identity();
  F(0, 2) = -step_y;
  F(1, 2) = step_x;
  F(0, 3) = dt * c;
  F(0, 4) = -dt * s;
  F(1, 3) = dt * s;
  F(1, 4) = dt * c;
  F(0, 5) = -0.5 * dt * step_y;
  F(1, 5) = 0.5 * dt * step_x;
  F(2, 5) = dt;
  // White acceleration over dt: position, its product with the velocity, velocity.
  Covariance Q = Covariance::Zero();
  const double speed = params_.speed_noise;
  Q.diagonal().head<2>().setConstant(speed * dt * dt * dt / 3);
  Q.block<2, 2>(0, 3) << c, -s, s, c;
  Q.block<2, 2>(0, 3) *= speed * dt * dt / 2;
  Q.block<2, 2>(3, 0) = Q.block<2, 2>(0, 3).transpose();
  Q.diagonal().segment<2>(3).setConstant(speed * dt);
  Q(2, 2) = params_.turn_noise * dt * dt * dt / 3;
  Q(2, 5) = params_.turn_noise * dt * dt / 2;
  Q(5, 2) = Q(2, 5);
  Q(5, 5) = params_.turn_noise * dt;
  state_[0] += step_x;
  state_[1] += step_y;
  state_[2] = WrapAngle(state_[2] + dt * state_[5]);
  covariance_ = F * covariance_ * F.transpose() + Q;
}

void MotionModel::Update(const PoseWithCovariance& measured) {
  Eigen::Vector3d innovation(measured.pose.x - state_[0],
                             measured.pose.y - state_[1],
                             WrapAngle(measured.pose.yaw - state_[2]));
  const Eigen::Matrix3d S = covariance_.topLeftCorner<3, 3>() + measured.covariance;
  const Eigen::Matrix<double, 3, 6> HP = covariance_.topRows<3>();
  const Eigen::Matrix<double, 6, 3> K = S.ldlt().solve(HP).transpose();
  state_ += K * innovation;
  state_[2] = WrapAngle(state_[2]);
  // Joseph form: stays positive definite despite rounding.
  Covariance I_KH = Covariance::Identity();
  I_KH.leftCols<3>() -= K;
  covariance_ = I_KH * covariance_ * I_KH.transpose() + K * measured.covariance * K.transpose();
}

void MotionModel::UpdateYaw(double yaw_rad, double variance_rad2) {
  const double innovation = WrapAngle(yaw_rad - state_[2]);
  const State K = covariance_.col(2) / (covariance_(2, 2) + variance_rad2);
  state_ += K * innovation;
  state_[2] = WrapAngle(state_[2]);
  Covariance I_KH = Covariance::Identity();
  I_KH.col(2) -= K;
  covariance_ = I_KH * covariance_ * I_KH.transpose() + K * variance_rad2 * K.transpose();
}

PoseWithCovariance MotionModel::Pose() const {
  return {{state_[0], state_[1], state_[2]}, covariance_.topLeftCorner<3, 3>()};
}

double SquaredDistance(const PoseWithCovariance& a, const PoseWithCovariance& b) {
  const Eigen::Vector3d difference(
      a.pose.x - b.pose.x, a.pose.y - b.pose.y, WrapAngle(a.pose.yaw - b.pose.yaw));
  const Eigen::Matrix3d spread = a.covariance + b.covariance;
  return difference.dot(spread.ldlt().solve(difference));
}

PoseWithCovariance Moved(const PoseWithCovariance& pose,
                         const Pose2& T_base_next,
                         const Eigen::Matrix3d& covariance) {
  return {pose.pose * T_base_next,
          ComposeCovariance(pose.pose, pose.covariance, T_base_next, covariance)};
}

}  // namespace ceilmap::localization
