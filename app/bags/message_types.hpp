#pragma once

#include <string>
#include <string_view>

namespace ceilmap::bags {

/// The types of the messages that ceilmap reads and writes, as ROS 2 spells them.
inline constexpr std::string_view kImageType = "sensor_msgs/msg/Image";
inline constexpr std::string_view kCompressedImageType = "sensor_msgs/msg/CompressedImage";
inline constexpr std::string_view kCameraInfoType = "sensor_msgs/msg/CameraInfo";
inline constexpr std::string_view kImuType = "sensor_msgs/msg/Imu";
inline constexpr std::string_view kOdometryType = "nav_msgs/msg/Odometry";
inline constexpr std::string_view kTransformsType = "tf2_msgs/msg/TFMessage";
inline constexpr std::string_view kPoseType = "geometry_msgs/msg/PoseWithCovarianceStamped";
inline constexpr std::string_view kPathType = "nav_msgs/msg/Path";
inline constexpr std::string_view kGridType = "nav_msgs/msg/OccupancyGrid";
inline constexpr std::string_view kDiagnosticsType = "diagnostic_msgs/msg/DiagnosticArray";

/// The definition of one of these types as an MCAP file embeds it (encoding "ros2msg"): its fields,
/// and those of every type that it contains after a line of '=' and its name. Fields, constants and
/// defaults are those of ROS 2 Humble and Jazzy, without comments.
/// @throws std::out_of_range for another type.
std::string MessageDefinition(std::string_view type);

}  // namespace ceilmap::bags
