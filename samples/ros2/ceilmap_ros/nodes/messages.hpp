#pragma once

#include <builtin_interfaces/msg/time.hpp>
#include <diagnostic_msgs/msg/diagnostic_status.hpp>
#include <geometry_msgs/msg/pose.hpp>
#include <geometry_msgs/msg/pose_with_covariance.hpp>
#include <geometry_msgs/msg/quaternion.hpp>
#include <nav_msgs/msg/occupancy_grid.hpp>
#include <optional>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>

#include "ceilmap_ros/logic/camera_match.hpp"
#include "ceilmap_ros/logic/ceiling_grid.hpp"
#include "ceilmap_ros/logic/health.hpp"
#include "ceilmap_ros/logic/map_to_odom.hpp"
#include "ceilmap_ros/logic/raw_image.hpp"
#include "ceilmap_ros/logic/stamp.hpp"

/// Between messages and the types of the logic, and nothing else.
namespace ceilmap_ros {

Stamp ToStamp(const builtin_interfaces::msg::Time& time);
builtin_interfaces::msg::Time ToTime(Stamp stamp);

/// Refers to the data of the message.
RawImage ToRawImage(const sensor_msgs::msg::Image& image);
CameraFacts ToCameraFacts(const sensor_msgs::msg::CameraInfo& info);

/// The planar part of a pose. @return nothing when its quaternion is no rotation.
std::optional<Pose2> ToPose2(const geometry_msgs::msg::Pose& pose);
geometry_msgs::msg::Pose ToPose(const Pose2& pose);
/// Rows and columns x, y and yaw of the 6 x 6 covariance.
Eigen::Matrix3d ToCovariance(const geometry_msgs::msg::PoseWithCovariance& pose);
/// What does not lie in the plane has covariance zero, as with AMCL.
geometry_msgs::msg::PoseWithCovariance ToPoseWithCovariance(const PoseWithCovariance& pose);

/// Without its header.
nav_msgs::msg::OccupancyGrid ToOccupancyGrid(const CeilingGrid& grid);
diagnostic_msgs::msg::DiagnosticStatus ToDiagnosticStatus(const Health& health);

}  // namespace ceilmap_ros
