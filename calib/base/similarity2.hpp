#pragma once

#include <Eigen/Core>

#include "calib/base/pose2.hpp"

namespace ceilmap {

/// Planar similarity transform, named as a pose: `S_a_b` transforms coordinates in frame b to frame
/// a, p_a = S_a_b * p_b = scale * R(yaw) * p_b + t, without reflection.
struct Similarity2 {
  Pose2 motion;      ///< R(yaw) and t, in a
  double scale = 1;  ///< > 0: lengths in a per length in b

  [[nodiscard]] Similarity2 Inverse() const;
};

/// p_a = S_a_b * p_b.
Eigen::Vector2d operator*(const Similarity2& S_a_b, const Eigen::Vector2d& p_b);
/// The pose in frame a: its position is transformed as a point, its yaw is rotated.
Pose2 operator*(const Similarity2& S_a_b, const Pose2& T_b_c);

}  // namespace ceilmap
