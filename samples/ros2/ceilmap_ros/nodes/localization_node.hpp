#pragma once

#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <nav_msgs/msg/occupancy_grid.hpp>
#include <rclcpp/rclcpp.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <string>

#include "ceilmap_ros/logic/localization_logic.hpp"
#include "ceilmap_ros/logic/task_runner.hpp"
#include "ceilmap_ros/nodes/common_parameters.hpp"
#include "ceilmap_ros/nodes/diagnostics.hpp"
#include "ceilmap_ros/nodes/fix_publisher.hpp"
#include "ceilmap_ros/nodes/sensor_topics.hpp"
#include "ceilmap_ros/nodes/worker.hpp"
#include "ceilmap_ros/srv/load_map.hpp"

namespace ceilmap_ros {

/// Component: finds and follows the robot on a map of the ceiling. README.md lists its topics,
/// services and parameters.
class LocalizationNode : public rclcpp::Node {
 public:
  /// @throws InputError when the parameters cannot be used.
  explicit LocalizationNode(const rclcpp::NodeOptions& options);

 private:
  using InitialPose = geometry_msgs::msg::PoseWithCovarianceStamped;
  using Trigger = std_srvs::srv::Trigger;

  void Step();
  void TakeInitialPose(const InitialPose& message);
  srv::LoadMap::Response Load(const std::string& path);

  CommonParameters parameters_;
  LocalizationLogic logic_;
  FixPublisher fixes_;
  rclcpp::Publisher<nav_msgs::msg::OccupancyGrid>::SharedPtr ceiling_map_;
  Diagnostics diagnostics_;
  SensorTopics sensors_;
  rclcpp::Subscription<InitialPose>::SharedPtr initial_pose_;
  rclcpp::Service<srv::LoadMap>::SharedPtr load_map_;
  rclcpp::Service<Trigger>::SharedPtr relocalize_;
  // Threads, which use all of the above.
  TaskRunner tasks_;
  Worker worker_;
};

}  // namespace ceilmap_ros
