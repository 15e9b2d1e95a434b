#include "calib/base/similarity2.hpp"

namespace ceilmap {

Similarity2 Similarity2::Inverse() const {
  const Eigen::Vector2d t = -(motion.Rotation().transpose() * motion.Translation()) / scale;
  return {{t.x(), t.y(), WrapAngle(-motion.yaw)}, 1 / scale};
}

Eigen::Vector2d operator*(const Similarity2& S_a_b, const Eigen::Vector2d& p_b) {
  return S_a_b.motion * Eigen::Vector2d(S_a_b.scale * p_b);
}

Pose2 operator*(const Similarity2& S_a_b, const Pose2& T_b_c) {
  const Eigen::Vector2d t = S_a_b * T_b_c.Translation();
  return {t.x(), t.y(), WrapAngle(S_a_b.motion.yaw + T_b_c.yaw)};
}

}  // namespace ceilmap
