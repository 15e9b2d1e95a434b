#pragma once

#include <Eigen/Core>

namespace ceilmap {

/// Wraps an angle to (-pi, pi]. Any finite input.
double WrapAngle(double angle);

/// Planar pose, i.e. an element of SE(2), defined as a coordinate transform: a pose named `T_a_b`
/// transforms coordinates in frame b to frame a, `p_a = T_a_b * p_b`, and `T_a_c = T_a_b * T_b_c`.
///
/// Frames follow REP-103/REP-105 (x forward, y left, yaw counter-clockwise seen from above). Metres
/// and radians; in a map made without a rig the unit of length is the pixel instead.
struct Pose2 {
  double x = 0;
  double y = 0;
  double yaw = 0;  ///< in (-pi, pi] for every pose that a function of this header returns

  [[nodiscard]] Pose2 Inverse() const;
  [[nodiscard]] Eigen::Vector2d Translation() const { return {x, y}; }
  [[nodiscard]] Eigen::Matrix2d Rotation() const;
};

/// T_a_c = T_a_b * T_b_c.
Pose2 operator*(const Pose2& T_a_b, const Pose2& T_b_c);
/// p_a = T_a_b * p_b.
Eigen::Vector2d operator*(const Pose2& T_a_b, const Eigen::Vector2d& p_b);

}  // namespace ceilmap
