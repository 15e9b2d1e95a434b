#pragma once

#include <memory>
#include <nav_msgs/msg/occupancy_grid.hpp>
#include <rclcpp/rclcpp.hpp>

#include "ceilmap_ros/logic/mapping_logic.hpp"
#include "ceilmap_ros/nodes/common_parameters.hpp"
#include "ceilmap_ros/nodes/diagnostics.hpp"
#include "ceilmap_ros/nodes/fix_publisher.hpp"
#include "ceilmap_ros/nodes/sensor_topics.hpp"
#include "ceilmap_ros/nodes/worker.hpp"
#include "ceilmap_ros/srv/save_map.hpp"

namespace ceilmap_ros {

/// Component: maps the ceiling while the robot drives. README.md lists its topics, services and
/// parameters.
class MappingNode : public rclcpp::Node {
 public:
  /// @throws InputError when the parameters cannot be used.
  explicit MappingNode(const rclcpp::NodeOptions& options);

 private:
  void Step();
  void PublishMosaic();

  CommonParameters parameters_;
  Stamp mosaic_period_ = 0;
  Stamp mosaic_at_ = 0;  // when it was published last; of the worker, as the map
  std::unique_ptr<MappingLogic> logic_;
  FixPublisher fixes_;
  rclcpp::Publisher<nav_msgs::msg::OccupancyGrid>::SharedPtr ceiling_map_;
  Diagnostics diagnostics_;
  SensorTopics sensors_;
  rclcpp::Service<srv::SaveMap>::SharedPtr save_map_;
  Worker worker_;  // uses all of the above
};

}  // namespace ceilmap_ros
