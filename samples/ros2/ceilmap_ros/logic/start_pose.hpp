#pragma once

#include <Eigen/Core>

#include "calib/base/pose_with_covariance.hpp"
#include "ceilmap_ros/logic/inbox.hpp"

namespace ceilmap_ros {

/// A pose that a user set on a map (RViz, initialpose).
/// @param covariance  of (x, y, yaw). One that is zero, or not positive definite, becomes 0.5 m and
///   15 degrees, as of a click on a map.
/// @throws InputError when a number is not finite.
PoseWithCovariance CheckedStart(const Pose2& T_map_base, const Eigen::Matrix3d& covariance);

/// The pose at the time of the frame: what the robot drove since the pose was set is added, where
/// the odometry knows it. @return nothing when the request has no pose.
std::optional<PoseWithCovariance> StartAtFrame(const StartRequest& start,
                                               const OdometryAnswer& at_start,
                                               const OdometryAnswer& at_frame);

}  // namespace ceilmap_ros
