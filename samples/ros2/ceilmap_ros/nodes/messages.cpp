#include "ceilmap_ros/nodes/messages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <diagnostic_msgs/msg/key_value.hpp>

namespace ceilmap_ros {
namespace {

/// Rows of x, y and yaw in a 6 x 6 covariance (x, y, z, roll, pitch, yaw).
constexpr std::array<std::size_t, 3> kPlanar{0, 1, 5};

geometry_msgs::msg::Quaternion ToQuaternion(double yaw_rad) {
  geometry_msgs::msg::Quaternion q;
  q.x = 0;
  q.y = 0;
  q.z = std::sin(0.5 * yaw_rad);
  q.w = std::cos(0.5 * yaw_rad);
  return q;
}

}  // namespace

Stamp ToStamp(const builtin_interfaces::msg::Time& time) {
  return time.sec * kSecond + time.nanosec;
}

builtin_interfaces::msg::Time ToTime(Stamp stamp) {
  builtin_interfaces::msg::Time time;
  const Stamp nanoseconds = ((stamp % kSecond) + kSecond) % kSecond;
  time.sec = static_cast<std::int32_t>((stamp - nanoseconds) / kSecond);
  time.nanosec = static_cast<std::uint32_t>(nanoseconds);
  return time;
}

RawImage ToRawImage(const sensor_msgs::msg::Image& image) {
  return {image.encoding,
          image.width,
          image.height,
          image.step,
          image.is_bigendian != 0,
          {image.data.data(), image.data.size()}};
}

CameraFacts ToCameraFacts(const sensor_msgs::msg::CameraInfo& info) {
  CameraFacts facts;
  facts.width = info.width;
  facts.height = info.height;
  facts.distortion_model = info.distortion_model;
  facts.d.assign(info.d.begin(), info.d.end());
  std::copy(info.k.begin(), info.k.end(), facts.k.begin());
  facts.binning_x = info.binning_x;
  facts.binning_y = info.binning_y;
  // All zero, or the whole sensor: no region.
  facts.region_of_interest = info.roi.x_offset != 0 || info.roi.y_offset != 0 ||
                             (info.roi.width != 0 && info.roi.width != info.width) ||
                             (info.roi.height != 0 && info.roi.height != info.height);
  return facts;
}

std::optional<Pose2> ToPose2(const geometry_msgs::msg::Pose& pose) {
  const auto& q = pose.orientation;
  const double norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  constexpr double kLargestError = 0.01;
  if (!(std::abs(norm - 1) <= kLargestError)) return std::nullopt;
  const double yaw =
      std::atan2(2 * (q.w * q.z + q.x * q.y), norm * norm - 2 * (q.y * q.y + q.z * q.z));
  return Pose2{pose.position.x, pose.position.y, yaw};
}

geometry_msgs::msg::Pose ToPose(const Pose2& pose) {
  geometry_msgs::msg::Pose message;
  message.position.x = pose.x;
  message.position.y = pose.y;
  message.position.z = 0;
  message.orientation = ToQuaternion(pose.yaw);
  return message;
}

Eigen::Matrix3d ToCovariance(const geometry_msgs::msg::PoseWithCovariance& pose) {
  Eigen::Matrix3d covariance;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t col = 0; col < 3; ++col) {
      covariance(static_cast<int>(row), static_cast<int>(col)) =
          pose.covariance[6 * kPlanar[row] + kPlanar[col]];
    }
  }
  return covariance;
}

geometry_msgs::msg::PoseWithCovariance ToPoseWithCovariance(const PoseWithCovariance& pose) {
  geometry_msgs::msg::PoseWithCovariance message;
  message.pose = ToPose(pose.pose);
  message.covariance.fill(0);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t col = 0; col < 3; ++col) {
      message.covariance[6 * kPlanar[row] + kPlanar[col]] =
          pose.covariance(static_cast<int>(row), static_cast<int>(col));
    }
  }
  return message;
}

nav_msgs::msg::OccupancyGrid ToOccupancyGrid(const CeilingGrid& grid) {
  nav_msgs::msg::OccupancyGrid message;
  message.info.resolution = static_cast<float>(grid.resolution_m);
  message.info.width = grid.width;
  message.info.height = grid.height;
  message.info.origin = ToPose({grid.origin_x_m, grid.origin_y_m, 0});
  message.data.assign(grid.cells.begin(), grid.cells.end());
  return message;
}

diagnostic_msgs::msg::DiagnosticStatus ToDiagnosticStatus(const Health& health) {
  using Status = diagnostic_msgs::msg::DiagnosticStatus;
  Status status;
  switch (health.level) {
    case Health::Level::kOk:
      status.level = Status::OK;
      break;
    case Health::Level::kWarn:
      status.level = Status::WARN;
      break;
    case Health::Level::kError:
      status.level = Status::ERROR;
      break;
    case Health::Level::kStale:
      status.level = Status::STALE;
      break;
  }
  status.message = health.message;
  for (const auto& [key, text] : health.values) {
    diagnostic_msgs::msg::KeyValue value;
    value.key = key;
    value.value = text;
    status.values.push_back(value);
  }
  return status;
}

}  // namespace ceilmap_ros
