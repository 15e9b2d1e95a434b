#include "ceilmap_ros/nodes/diagnostics.hpp"

#include <chrono>
#include <utility>

#include "ceilmap_ros/nodes/messages.hpp"

namespace ceilmap_ros {

Diagnostics::Diagnostics(rclcpp::Node& node,
                         std::string robot,
                         std::function<Health(Stamp now)> judge)
    : node_(node),
      robot_(std::move(robot)),
      judge_(std::move(judge)),
      publisher_(node.create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics",
                                                                              rclcpp::QoS(10))),
      timer_(node.create_wall_timer(std::chrono::seconds(1), [this] { Publish(); })) {}

void Diagnostics::Publish() {
  const Stamp now = node_.now().nanoseconds();
  diagnostic_msgs::msg::DiagnosticArray message;
  message.header.stamp = ToTime(now);
  message.status.push_back(ToDiagnosticStatus(judge_(now)));
  message.status.back().name = node_.get_fully_qualified_name();
  message.status.back().hardware_id = robot_;
  publisher_->publish(message);
}

}  // namespace ceilmap_ros
