#pragma once

#include <cstdint>
#include <vector>

#include "app/bags/messages.hpp"
#include "app/bags/result_messages.hpp"

namespace ceilmap::bags {

/// The time of a message. @throws InputError for a time that ROS cannot express: before 1970, or
/// after 2038.
std::int64_t Nanoseconds(double stamp_s);

/// Serializes a message for McapWriter::Write: CDR, little endian (CdrWriter).
std::vector<std::uint8_t> Encode(const ImageMessage& message);
std::vector<std::uint8_t> Encode(const CompressedImageMessage& message);
/// An image that is not rectified: R is the identity, P = [K | 0].
std::vector<std::uint8_t> Encode(const CameraInfoMessage& message);
std::vector<std::uint8_t> Encode(const OdometryMessage& message);
/// Orientation and acceleration are marked as not measured (their covariance begins with -1).
std::vector<std::uint8_t> Encode(const ImuMessage& message);
/// tf2_msgs/msg/TFMessage.
std::vector<std::uint8_t> Encode(const std::vector<TransformStamped>& transforms);
std::vector<std::uint8_t> Encode(const PoseMessage& message);
std::vector<std::uint8_t> Encode(const PathMessage& message);
std::vector<std::uint8_t> Encode(const GridMessage& message);
std::vector<std::uint8_t> Encode(const DiagnosticsMessage& message);

}  // namespace ceilmap::bags
