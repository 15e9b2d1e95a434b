#pragma once

// The name with .h ends with the distributions after Jazzy.
#if __has_include(<tf2_ros/transform_broadcaster.hpp>)
#include <tf2_ros/transform_broadcaster.hpp>
#else
#include <tf2_ros/transform_broadcaster.h>
#endif

#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <memory>
#include <rclcpp/rclcpp.hpp>
#include <string>

#include "ceilmap_ros/logic/fix.hpp"
#include "ceilmap_ros/nodes/common_parameters.hpp"

namespace ceilmap_ros {

/// Publishes what is sure: the pose on the topic pose, and map -> odom to TF.
class FixPublisher {
 public:
  FixPublisher(rclcpp::Node& node, const CommonParameters& parameters);

  void Publish(const Fix& fix);

 private:
  using PoseMessage = geometry_msgs::msg::PoseWithCovarianceStamped;

  std::string map_frame_;
  std::string odom_frame_;
  rclcpp::Publisher<PoseMessage>::SharedPtr pose_;
  std::unique_ptr<tf2_ros::TransformBroadcaster> tf_;  // null: not wanted
};

}  // namespace ceilmap_ros
