#include "calib/base/pose2.hpp"

#include <cmath>
#include <numbers>

namespace ceilmap {

double WrapAngle(double angle) {
  const double wrapped = std::remainder(angle, 2 * std::numbers::pi);  // [-pi, pi]
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

Pose2 Pose2::Inverse() const {
  const Eigen::Vector2d t = -(Rotation().transpose() * Translation());
  return {t.x(), t.y(), WrapAngle(-yaw)};
}

Eigen::Matrix2d Pose2::Rotation() const {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

Pose2 operator*(const Pose2& T_a_b, const Pose2& T_b_c) {
  const Eigen::Vector2d t = T_a_b * T_b_c.Translation();
  return {t.x(), t.y(), WrapAngle(T_a_b.yaw + T_b_c.yaw)};
}

Eigen::Vector2d operator*(const Pose2& T_a_b, const Eigen::Vector2d& p_b) {
  return T_a_b.Rotation() * p_b + T_a_b.Translation();
}

}  // namespace ceilmap
