#pragma once

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <functional>
#include <rclcpp/rclcpp.hpp>
#include <string>

#include "ceilmap_ros/logic/health.hpp"

namespace ceilmap_ros {

/// Publishes the health of a node to /diagnostics, once a second.
class Diagnostics {
 public:
  /// @param node  must outlive this. @param judge  the health at a time of the node's clock.
  Diagnostics(rclcpp::Node& node, std::string robot, std::function<Health(Stamp now)> judge);

 private:
  void Publish();

  rclcpp::Node& node_;
  std::string robot_;
  std::function<Health(Stamp now)> judge_;
  rclcpp::Publisher<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr publisher_;
  rclcpp::TimerBase::SharedPtr timer_;
};

}  // namespace ceilmap_ros
