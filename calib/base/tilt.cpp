#include "calib/base/tilt.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ceilmap {

Eigen::Isometry3d Tilt::T_level_base() const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation().z() = lift_m;
  T.linear() = (Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return T;
}

double TiltAngles::Sigmas() const {
  return std::sqrt(angles.dot(covariance.inverse() * angles));
}

Eigen::Isometry3d ToSpace(const Pose2& T_map_base, const Tilt& tilt) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << T_map_base.x, T_map_base.y, 0;
  T.linear() = Eigen::AngleAxisd(T_map_base.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return T * tilt.T_level_base();
}

PlanarTilt FromSpace(const Eigen::Isometry3d& T_map_base) {
  const Eigen::Matrix3d R = T_map_base.linear();
  const Eigen::Vector3d t = T_map_base.translation();
  PlanarTilt result;
  result.pose = {t.x(), t.y(), std::atan2(R(1, 0), R(0, 0))};
  result.tilt.pitch_rad = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
  result.tilt.roll_rad = std::atan2(R(2, 1), R(2, 2));
  result.tilt.lift_m = t.z();
  return result;
}

}  // namespace ceilmap
