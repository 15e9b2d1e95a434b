#pragma once

#include <Eigen/Geometry>

namespace ceilmap::simulator {

/// Pose between two poses near each other: the positions linearly, the orientations on the shortest
/// arc. @param fraction  0: at a; 1: at b.
inline Eigen::Isometry3d Between(const Eigen::Isometry3d& T_map_a,
                                 const Eigen::Isometry3d& T_map_b,
                                 double fraction) {
  const Eigen::Quaterniond a(T_map_a.linear());
  const Eigen::Quaterniond b(T_map_b.linear());
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = a.slerp(fraction, b).toRotationMatrix();
  T.translation() = (1 - fraction) * T_map_a.translation() + fraction * T_map_b.translation();
  return T;
}

}  // namespace ceilmap::simulator
