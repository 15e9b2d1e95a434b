#pragma once

#include <nav_msgs/msg/odometry.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <string>

#include "ceilmap_ros/logic/inbox.hpp"
#include "ceilmap_ros/logic/raw_image.hpp"
#include "ceilmap_ros/nodes/common_parameters.hpp"

namespace ceilmap_ros {

/// Subscribes to the sensors of the rig and fills the inbox: ceiling/image, ceiling/camera_info,
/// odom; forward/image and omni/image where the rig has these cameras; imu where it is wanted.
class SensorTopics {
 public:
  /// @param node, inbox  must outlive this.
  SensorTopics(rclcpp::Node& node, const CommonParameters& parameters, Inbox& inbox);

 private:
  using Image = sensor_msgs::msg::Image;

  void TakeCeiling(const Image& message);
  void TakeOther(const Image& message, Colours colours, void (Inbox::*add)(const StampedImage&));
  void TakeOdometry(const nav_msgs::msg::Odometry& message);
  [[nodiscard]] cv::Mat DecodeOrWarn(const Image& message, Colours colours);
  /// At most once in five seconds.
  void Warn(const std::string& text);

  rclcpp::Node& node_;
  Inbox& inbox_;
  std::string odom_frame_;
  std::string base_frame_;
  rclcpp::Subscription<Image>::SharedPtr ceiling_;
  rclcpp::Subscription<Image>::SharedPtr forward_;
  rclcpp::Subscription<Image>::SharedPtr omni_;
  rclcpp::Subscription<sensor_msgs::msg::CameraInfo>::SharedPtr camera_info_;
  rclcpp::Subscription<nav_msgs::msg::Odometry>::SharedPtr odometry_;
  rclcpp::Subscription<sensor_msgs::msg::Imu>::SharedPtr imu_;
};

}  // namespace ceilmap_ros
