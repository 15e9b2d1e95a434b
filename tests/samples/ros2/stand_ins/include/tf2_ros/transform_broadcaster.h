#pragma once

#include <geometry_msgs/msg/transform_stamped.hpp>
#include <rclcpp/rclcpp.hpp>
#include <tf2_msgs/msg/tf_message.hpp>
#include <vector>

/// A stand-in of tf2_ros.
namespace tf2_ros {

// NOLINTBEGIN(readability-identifier-naming)
class TransformBroadcaster {
 public:
  template <class NodeT>
  explicit TransformBroadcaster(NodeT&& node, const rclcpp::QoS& qos = rclcpp::QoS(100))
      : publisher_(node.template create_publisher<tf2_msgs::msg::TFMessage>("/tf", qos)) {}

  void sendTransform(const geometry_msgs::msg::TransformStamped& transform) {
    sendTransform(std::vector<geometry_msgs::msg::TransformStamped>{transform});
  }
  void sendTransform(const std::vector<geometry_msgs::msg::TransformStamped>& transforms) {
    tf2_msgs::msg::TFMessage message;
    message.transforms = transforms;
    publisher_->publish(message);
  }

 private:
  rclcpp::Publisher<tf2_msgs::msg::TFMessage>::SharedPtr publisher_;
};
// NOLINTEND(readability-identifier-naming)

}  // namespace tf2_ros
