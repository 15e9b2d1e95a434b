#include "compensation/tilt_filter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ceilmap::compensation {

namespace {

// Initial standard deviations of the angles, rad, and of the rates, rad/s.
constexpr double kFirstSigmaRad = 0.1;
constexpr double kFirstRateSigma = 0.5;
// A measurement with a larger innovation, in standard deviations, is rejected.
constexpr double kMaxSigmas = 5;
// After a longer gap between frames, s, the rates are reset.
constexpr double kForgetS = 0.5;
// Rates do not continue for a longer time without a measurement, s, of more than this number of
// frames: a wheel climbs a cable within 0.1 s, and a false rate would tip the robot over.
constexpr double kBridgedS = 0.1;
constexpr double kBridgedFrames = 1.5;

}  // namespace

void TiltFilter::ForgetRates() {
  state_.tail<2>().setZero();
  covariance_.rightCols<2>().setZero();
  covariance_.bottomRows<2>().setZero();
  covariance_.bottomRightCorner<2, 2>() =
      kFirstRateSigma * kFirstRateSigma * Eigen::Matrix2d::Identity();
}

void TiltFilter::Predict(double stamp_s) {
  if (!stamp_s_) {
    covariance_.topLeftCorner<2, 2>() =
        kFirstSigmaRad * kFirstSigmaRad * Eigen::Matrix2d::Identity();
    ForgetRates();
    measured_s_ = stamp_s;
  } else {
    const double dt = stamp_s - *stamp_s_;
    if (dt > kForgetS) ForgetRates();
    if (stamp_s - measured_s_ > std::max(kBridgedS, kBridgedFrames * dt)) {
      state_.tail<2>().setZero();
    }
    Eigen::Matrix4d step = Eigen::Matrix4d::Identity();
    step.topRightCorner<2, 2>() = dt * Eigen::Matrix2d::Identity();
    // Constant acceleration over the step.
    Eigen::Matrix<double, 4, 2> push;
    push << 0.5 * dt * dt * Eigen::Matrix2d::Identity(), dt * Eigen::Matrix2d::Identity();
    state_ = step * state_;
    covariance_ = step * covariance_ * step.transpose() +
                  params_.acceleration * params_.acceleration * push * push.transpose();
  }
  stamp_s_ = stamp_s;
}

bool TiltFilter::Update(const TiltAngles& measured) {
  const Eigen::Vector2d off = measured.angles - state_.head<2>();
  const Eigen::Matrix2d spread = covariance_.topLeftCorner<2, 2>() + measured.covariance;
  const Eigen::Matrix2d weight = spread.inverse();
  if (!(off.dot(weight * off) <= kMaxSigmas * kMaxSigmas)) return false;
  measured_s_ = *stamp_s_;
  const Eigen::Matrix<double, 4, 2> gain = covariance_.leftCols<2>() * weight;
  state_ += gain * off;
  covariance_ -= gain * covariance_.topRows<2>();
  covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
  return true;
}

void TiltFilter::Restart(const TiltAngles& measured) {
  if (stamp_s_) measured_s_ = *stamp_s_;
  state_.head<2>() = measured.angles;
  covariance_.topLeftCorner<2, 2>() = measured.covariance;
  ForgetRates();
}

}  // namespace ceilmap::compensation
