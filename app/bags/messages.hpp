#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "app/bags/topic.hpp"

/// The ROS messages that ceilmap reads and writes, with the fields that it uses. Frames and units
/// are those of the messages' definitions (metres, radians, REP-103).
namespace ceilmap::bags {

struct Header {
  std::int64_t stamp_ns = 0;  ///< since 1970, or since the start of a simulation
  std::string frame_id;
};

/// sensor_msgs/msg/Image. The pixels are not copied.
struct ImageMessage {
  Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string encoding;  ///< "mono8", "bayer_rggb8", ...
  bool big_endian = false;
  std::uint32_t step = 0;  ///< bytes of a row
  std::span<const std::uint8_t> data;
};

/// sensor_msgs/msg/CompressedImage: JPEG or PNG, told by the data. The data are not copied.
struct CompressedImageMessage {
  Header header;
  std::string format;
  std::span<const std::uint8_t> data;
};

/// sensor_msgs/msg/CameraInfo without binning and region of interest.
struct CameraInfoMessage {
  Header header;
  std::uint32_t height = 0;
  std::uint32_t width = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{};
};

/// geometry_msgs/msg/Transform and geometry_msgs/msg/Pose.
struct Transform {
  std::array<double, 3> translation{};
  std::array<double, 4> rotation{0, 0, 0, 1};  ///< quaternion x, y, z, w
};

/// nav_msgs/msg/Odometry. Covariances are row-major in x, y, z, roll, pitch, yaw.
struct OdometryMessage {
  Header header;
  std::string child_frame_id;
  Transform pose;
  std::array<double, 36> pose_covariance{};
  std::array<double, 3> linear{};  ///< in child_frame_id
  std::array<double, 3> angular{};
  std::array<double, 36> twist_covariance{};
};

/// sensor_msgs/msg/Imu: the angular velocity only.
struct ImuMessage {
  Header header;
  std::array<double, 3> angular_velocity{};  ///< rad/s, in frame_id
};

/// One transform of tf2_msgs/msg/TFMessage: p_frame_id = transform * p_child_frame_id.
struct TransformStamped {
  Header header;
  std::string child_frame_id;
  Transform transform;
};

/// Decoders. @param data  as RawMessage::data. @throws MessageError when it ends early or a length
/// in it is impossible.
ImageMessage DecodeImage(std::span<const std::uint8_t> data, MessageEncoding encoding);
CompressedImageMessage DecodeCompressedImage(std::span<const std::uint8_t> data,
                                             MessageEncoding encoding);
CameraInfoMessage DecodeCameraInfo(std::span<const std::uint8_t> data, MessageEncoding encoding);
OdometryMessage DecodeOdometry(std::span<const std::uint8_t> data, MessageEncoding encoding);
ImuMessage DecodeImu(std::span<const std::uint8_t> data, MessageEncoding encoding);
std::vector<TransformStamped> DecodeTransforms(std::span<const std::uint8_t> data,
                                               MessageEncoding encoding);
/// The header alone, of every type above but TFMessage.
Header DecodeHeader(std::span<const std::uint8_t> data, MessageEncoding encoding);

}  // namespace ceilmap::bags
