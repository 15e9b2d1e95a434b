#include "calib/wheels/relative_motion.hpp"

namespace ceilmap::wheels {

Eigen::Matrix3d RelativeMotion::Covariance() const {
  Eigen::Matrix3d covariance = noise + common * common.transpose();
  covariance.diagonal().head<2>().array() += slips.Variance(travel_m);
  return covariance;
}

PoseWithCovariance RelativeMotion::From(const PoseWithCovariance& before) const {
  return {before.pose * T_before_now,
          ComposeCovariance(before.pose, before.covariance, T_before_now, Covariance())};
}

PoseWithCovariance RelativeMotion::Back(const PoseWithCovariance& now) const {
  const Pose2 T_now_before = T_before_now.Inverse();
  // Derivative of the inverse's (x, y, yaw).
  Eigen::Matrix3d J = -Eigen::Matrix3d::Identity();
  J.topLeftCorner<2, 2>() = -T_before_now.Rotation().transpose();
  J.topRightCorner<2, 1>() = Eigen::Vector2d(-T_now_before.y, T_now_before.x) * -1;
  return {
      now.pose * T_now_before,
      ComposeCovariance(now.pose, now.covariance, T_now_before, J * Covariance() * J.transpose())};
}

RelativeTurn operator+(const RelativeTurn& a, const RelativeTurn& b) {
  return {a.turn_rad + b.turn_rad,
          a.noise_rad2 + b.noise_rad2,
          a.common_rad + b.common_rad,
          a.may_slip || b.may_slip};
}

bool IsUsable(const PoseWithCovariance& predicted) {
  constexpr double kMaxSigmaM = 2;
  constexpr double kMaxSigmaRad = 0.8;
  const Eigen::Matrix3d& covariance = predicted.covariance;
  return covariance(0, 0) + covariance(1, 1) < kMaxSigmaM * kMaxSigmaM &&
         covariance(2, 2) < kMaxSigmaRad * kMaxSigmaRad;
}

RelativeMotion operator*(const RelativeMotion& a, const RelativeMotion& b) {
  RelativeMotion both;
  both.T_before_now = a.T_before_now * b.T_before_now;
  both.noise = ComposeCovariance(a.T_before_now, a.noise, b.T_before_now, b.noise);
  const Eigen::Matrix2d R = a.T_before_now.Rotation();
  const Eigen::Vector2d step = R * b.T_before_now.Translation();
  // A turn by which `a` is wrong turns the step of `b`.
  both.common = a.common;
  both.common.topRows<2>() +=
      Eigen::Vector2d(-step.y(), step.x()) * a.common.row(2) + R * b.common.topRows<2>();
  both.common.row(2) += b.common.row(2);
  both.travel_m = a.travel_m + b.travel_m;
  both.slips = b.travel_m > 0 ? b.slips : a.slips;
  return both;
}

std::optional<RelativeMotion> Joined(const std::optional<RelativeMotion>& a,
                                     const std::optional<RelativeMotion>& b) {
  if (!a || !b) return std::nullopt;
  return *a * *b;
}

}  // namespace ceilmap::wheels
