#include "calib/base/pose_with_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace ceilmap {

Eigen::Matrix3d ComposeCovariance(const Pose2& T_a_b,
                                  const Eigen::Matrix3d& cov_a_b,
                                  const Pose2& T_b_c,
                                  const Eigen::Matrix3d& cov_b_c) {
  const Eigen::Vector2d arm = T_a_b.Rotation() * T_b_c.Translation();
  Eigen::Matrix3d by_first = Eigen::Matrix3d::Identity();
  by_first(0, 2) = -arm.y();
  by_first(1, 2) = arm.x();
  Eigen::Matrix3d by_second = Eigen::Matrix3d::Identity();
  by_second.topLeftCorner<2, 2>() = T_a_b.Rotation();
  return by_first * cov_a_b * by_first.transpose() + by_second * cov_b_c * by_second.transpose();
}

PoseWithCovariance Fused(const PoseWithCovariance& a, const PoseWithCovariance& b) {
  const Eigen::Matrix3d gain = (a.covariance + b.covariance).ldlt().solve(a.covariance).transpose();
  const Eigen::Vector3d step =
      gain *
      Eigen::Vector3d(b.pose.x - a.pose.x, b.pose.y - a.pose.y, WrapAngle(b.pose.yaw - a.pose.yaw));
  return {{a.pose.x + step.x(), a.pose.y + step.y(), WrapAngle(a.pose.yaw + step.z())},
          a.covariance - gain * a.covariance};
}

Pose2 Interpolate(const Pose2& T_a_b, double factor) {
  // The constant-velocity arc: exp(factor * log(T)).
  const double yaw = T_a_b.yaw;
  const auto integral = [](double angle) {
    // V(angle) of exp: [[sin/a, -(1-cos)/a], [(1-cos)/a, sin/a]], with its series at 0.
    const double a2 = angle * angle;
    const double s = std::abs(angle) < 1e-4 ? 1 - a2 / 6 : std::sin(angle) / angle;
    const double c = std::abs(angle) < 1e-4 ? angle / 2 : (1 - std::cos(angle)) / angle;
    Eigen::Matrix2d v;
    v << s, -c, c, s;
    return v;
  };
  const Eigen::Vector2d velocity = integral(yaw).inverse() * T_a_b.Translation();
  const Eigen::Vector2d t = integral(factor * yaw) * (factor * velocity);
  return {t.x(), t.y(), WrapAngle(factor * yaw)};
}

}  // namespace ceilmap
