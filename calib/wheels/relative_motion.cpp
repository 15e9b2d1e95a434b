#include "calib/wheels/relative_motion.hpp"

namespace ceilmap::wheels {

PoseWithCovariance RelativeMotion::From(const PoseWithCovariance& before) const {
  return {before.pose * T_before_now,
          ComposeCovariance(before.pose, before.covariance, T_before_now, Covariance())};
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
  return both;
}

}  // namespace ceilmap::wheels
