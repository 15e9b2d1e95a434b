#include "calib/base/stamped_pose.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap {

StampedPose ToStampedPose(double stamp_s, const Pose2& T_map_base, const Tilt& tilt) {
  const Eigen::Quaterniond yaw(std::cos(T_map_base.yaw / 2), 0, 0, std::sin(T_map_base.yaw / 2));
  if (tilt.IsLevel()) return {stamp_s, {T_map_base.x, T_map_base.y, 0}, yaw};
  return {stamp_s,
          {T_map_base.x, T_map_base.y, tilt.lift_m},
          yaw * Eigen::Quaterniond(tilt.T_level_base().linear())};
}

double YawOf(const StampedPose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return std::atan2(2 * (q.w() * q.z() + q.x() * q.y()), 1 - 2 * (q.y() * q.y() + q.z() * q.z()));
}

double PitchOf(const StampedPose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return std::asin(std::clamp(2 * (q.w() * q.y() - q.z() * q.x()), -1.0, 1.0));
}

double RollOf(const StampedPose& pose) {
  const Eigen::Quaterniond& q = pose.orientation;
  return std::atan2(2 * (q.w() * q.x() + q.y() * q.z()), 1 - 2 * (q.x() * q.x() + q.y() * q.y()));
}

Pose2 PlanarPose(const StampedPose& pose) {
  return {pose.position.x(), pose.position.y(), YawOf(pose)};
}

std::vector<double> PathLengths(const std::vector<StampedPose>& poses) {
  std::vector<double> lengths(poses.size(), 0);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Vector2d step = (poses[i].position - poses[i - 1].position).head<2>();
    lengths[i] = lengths[i - 1] + step.norm();
  }
  return lengths;
}

}  // namespace ceilmap
