#include "ceilmap_ros/nodes/fix_publisher.hpp"

#include <geometry_msgs/msg/transform_stamped.hpp>

#include "ceilmap_ros/nodes/messages.hpp"

namespace ceilmap_ros {

FixPublisher::FixPublisher(rclcpp::Node& node, const CommonParameters& parameters)
    : map_frame_(parameters.map_frame),
      odom_frame_(parameters.odom_frame),
      pose_(node.create_publisher<PoseMessage>("pose", rclcpp::QoS(10))) {
  if (parameters.publish_tf) tf_ = std::make_unique<tf2_ros::TransformBroadcaster>(node);
}

void FixPublisher::Publish(const Fix& fix) {
  if (!fix.pose) return;
  PoseMessage pose;
  pose.header.stamp = ToTime(fix.stamp);
  pose.header.frame_id = map_frame_;
  pose.pose = ToPoseWithCovariance(*fix.pose);
  pose_->publish(pose);
  if (!tf_ || !fix.map_to_odom) return;
  geometry_msgs::msg::TransformStamped transform;
  transform.header.stamp = ToTime(fix.map_to_odom->valid_until);
  transform.header.frame_id = map_frame_;
  transform.child_frame_id = odom_frame_;
  const geometry_msgs::msg::Pose odom = ToPose(fix.map_to_odom->T_map_odom);
  transform.transform.translation.x = odom.position.x;
  transform.transform.translation.y = odom.position.y;
  transform.transform.translation.z = odom.position.z;
  transform.transform.rotation = odom.orientation;
  tf_->sendTransform(transform);
}

}  // namespace ceilmap_ros
