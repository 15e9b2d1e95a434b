#include "ceilmap_ros/logic/start_pose.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "calib/base/error.hpp"

namespace ceilmap_ros {

PoseWithCovariance CheckedStart(const Pose2& T_map_base, const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d values(T_map_base.x, T_map_base.y, T_map_base.yaw);
  if (!values.allFinite() || !covariance.allFinite()) {
    throw ceilmap::InputError("initialpose has a number that is not finite");
  }
  const Eigen::Matrix3d symmetric = 0.5 * (covariance + covariance.transpose());
  if (symmetric.llt().info() == Eigen::Success) return {T_map_base, symmetric};
  constexpr double kSigmaM = 0.5;
  constexpr double kSigmaRad = 15 * std::numbers::pi / 180;
  PoseWithCovariance start{T_map_base};
  start.covariance.diagonal() << kSigmaM * kSigmaM, kSigmaM * kSigmaM, kSigmaRad * kSigmaRad;
  return start;
}

std::optional<PoseWithCovariance> StartAtFrame(const StartRequest& start,
                                               const OdometryAnswer& at_start,
                                               const OdometryAnswer& at_frame) {
  if (!start.pose || !at_start.Known() || !at_frame.Known()) return start.pose;
  const auto& [pose, covariance] = *start.pose;
  const Pose2 T_start_frame = at_start.T_odom_base.Inverse() * at_frame.T_odom_base;
  return PoseWithCovariance{
      pose * T_start_frame,
      ceilmap::ComposeCovariance(pose, covariance, T_start_frame, Eigen::Matrix3d::Zero())};
}

}  // namespace ceilmap_ros
