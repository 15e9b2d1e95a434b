#include "app/bags/messages.hpp"

#include "app/bags/cdr.hpp"
#include "app/bags/message_fields.hpp"

namespace ceilmap::bags {

ImageMessage DecodeImage(std::span<const std::uint8_t> data, MessageEncoding encoding) {
  CdrReader reader(data, encoding);
  ImageMessage message;
  message.header = ReadHeader(reader);
  message.height = reader.Number<std::uint32_t>();
  message.width = reader.Number<std::uint32_t>();
  message.encoding = reader.Text();
  message.big_endian = reader.Number<std::uint8_t>() != 0;
  message.step = reader.Number<std::uint32_t>();
  message.data = reader.Bytes();
  return message;
}

CompressedImageMessage DecodeCompressedImage(std::span<const std::uint8_t> data,
                                             MessageEncoding encoding) {
  CdrReader reader(data, encoding);
  CompressedImageMessage message;
  message.header = ReadHeader(reader);
  message.format = reader.Text();
  message.data = reader.Bytes();
  return message;
}

CameraInfoMessage DecodeCameraInfo(std::span<const std::uint8_t> data, MessageEncoding encoding) {
  CdrReader reader(data, encoding);
  CameraInfoMessage message;
  message.header = ReadHeader(reader);
  message.height = reader.Number<std::uint32_t>();
  message.width = reader.Number<std::uint32_t>();
  message.distortion_model = reader.Text();
  message.d = reader.Doubles();
  reader.Numbers(message.k);
  return message;
}

OdometryMessage DecodeOdometry(std::span<const std::uint8_t> data, MessageEncoding encoding) {
  CdrReader reader(data, encoding);
  OdometryMessage message;
  message.header = ReadHeader(reader);
  message.child_frame_id = reader.Text();
  message.pose = ReadTransform(reader);
  reader.Numbers(message.pose_covariance);
  reader.Numbers(message.linear);
  reader.Numbers(message.angular);
  reader.Numbers(message.twist_covariance);
  return message;
}

ImuMessage DecodeImu(std::span<const std::uint8_t> data, MessageEncoding encoding) {
  CdrReader reader(data, encoding);
  ImuMessage message;
  message.header = ReadHeader(reader);
  std::array<double, 4> orientation{};
  std::array<double, 9> orientation_covariance{};
  reader.Numbers(orientation);
  reader.Numbers(orientation_covariance);
  reader.Numbers(message.angular_velocity);
  return message;
}

std::vector<TransformStamped> DecodeTransforms(std::span<const std::uint8_t> data,
                                               MessageEncoding encoding) {
  CdrReader reader(data, encoding);
  constexpr std::size_t kMinBytes = 72;  // time, two empty texts, seven numbers
  std::vector<TransformStamped> transforms(reader.Length(kMinBytes));
  for (TransformStamped& transform : transforms) {
    transform.header = ReadHeader(reader);
    transform.child_frame_id = reader.Text();
    transform.transform = ReadTransform(reader);
  }
  return transforms;
}

Header DecodeHeader(std::span<const std::uint8_t> data, MessageEncoding encoding) {
  CdrReader reader(data, encoding);
  return ReadHeader(reader);
}

}  // namespace ceilmap::bags
