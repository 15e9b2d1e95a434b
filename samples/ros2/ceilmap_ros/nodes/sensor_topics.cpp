#include "ceilmap_ros/nodes/sensor_topics.hpp"

#include <fmt/format.h>

#include "calib/base/error.hpp"
#include "ceilmap_ros/nodes/messages.hpp"

namespace ceilmap_ros {
namespace {

constexpr std::size_t kSampleQueue = 200;
constexpr int kWarnEveryMs = 5000;

}  // namespace

SensorTopics::SensorTopics(rclcpp::Node& node, const CommonParameters& parameters, Inbox& inbox)
    : node_(node),
      inbox_(inbox),
      odom_frame_(parameters.odom_frame),
      base_frame_(parameters.base_frame) {
  using CameraInfo = sensor_msgs::msg::CameraInfo;
  using Imu = sensor_msgs::msg::Imu;
  using Odometry = nav_msgs::msg::Odometry;
  const rclcpp::QoS images = rclcpp::SensorDataQoS();
  const rclcpp::QoS samples = rclcpp::SensorDataQoS().keep_last(kSampleQueue);
  ceiling_ = node.create_subscription<Image>(
      "ceiling/image", images, [this](Image::ConstSharedPtr image) { TakeCeiling(*image); });
  camera_info_ = node.create_subscription<CameraInfo>(
      "ceiling/camera_info", images, [this](CameraInfo::ConstSharedPtr info) {
        inbox_.SetCamera(ToCameraFacts(*info));
      });
  odometry_ = node.create_subscription<Odometry>(
      "odom", samples, [this](Odometry::ConstSharedPtr odometry) { TakeOdometry(*odometry); });
  if (parameters.rig.forward) {
    forward_ = node.create_subscription<Image>(
        "forward/image", images, [this](Image::ConstSharedPtr image) {
          TakeOther(*image, Colours::kGrey, &Inbox::AddForward);
        });
  }
  if (parameters.rig.omni) {
    omni_ =
        node.create_subscription<Image>("omni/image", images, [this](Image::ConstSharedPtr image) {
          TakeOther(*image, Colours::kIfItHasAny, &Inbox::AddOmni);
        });
  }
  if (parameters.use_imu) {
    imu_ = node.create_subscription<Imu>("imu", samples, [this](Imu::ConstSharedPtr imu) {
      inbox_.AddGyro({ToStamp(imu->header.stamp), imu->angular_velocity.z});
    });
  }
}

void SensorTopics::Warn(const std::string& text) {
  RCLCPP_WARN_THROTTLE(node_.get_logger(), *node_.get_clock(), kWarnEveryMs, "%s", text.c_str());
}

cv::Mat SensorTopics::DecodeOrWarn(const Image& message, Colours colours) {
  try {
    return Decode(ToRawImage(message), colours);
  } catch (const ceilmap::InputError& error) {
    Warn(error.what());
    return {};
  }
}

void SensorTopics::TakeCeiling(const Image& message) {
  const cv::Mat grey = DecodeOrWarn(message, Colours::kGrey);
  if (grey.empty()) return;
  inbox_.AddCeiling(grey, ToStamp(message.header.stamp), node_.now().nanoseconds());
}

void SensorTopics::TakeOther(const Image& message,
                             Colours colours,
                             void (Inbox::*add)(const StampedImage&)) {
  const cv::Mat pixels = DecodeOrWarn(message, colours);
  if (!pixels.empty()) (inbox_.*add)({pixels, ToStamp(message.header.stamp)});
}

void SensorTopics::TakeOdometry(const nav_msgs::msg::Odometry& message) {
  const auto pose = ToPose2(message.pose.pose);
  if (!pose) {
    Warn("odom has a quaternion that is no rotation");
    return;
  }
  if (message.header.frame_id != odom_frame_ || message.child_frame_id != base_frame_) {
    Warn(
        fmt::format("odom is {} -> {}, but the parameters say {} -> {}; the transform is "
                    "published for the parameters",
                    message.header.frame_id,
                    message.child_frame_id,
                    odom_frame_,
                    base_frame_));
  }
  inbox_.AddOdometry({ToStamp(message.header.stamp), *pose});
}

}  // namespace ceilmap_ros
