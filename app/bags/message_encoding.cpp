#include "app/bags/message_encoding.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "app/bags/cdr_writer.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::bags {
namespace {

constexpr std::int64_t kPerSecond = 1'000'000'000;

void Put(std::int64_t stamp_ns, CdrWriter& out) {
  out.Put(static_cast<std::int32_t>(stamp_ns / kPerSecond));
  out.Put(static_cast<std::uint32_t>(stamp_ns % kPerSecond));
}

void Put(const Header& header, CdrWriter& out) {
  Put(header.stamp_ns, out);
  out.PutText(header.frame_id);
}

void Put(const Transform& transform, CdrWriter& out) {
  out.PutAll(transform.translation);
  out.PutAll(transform.rotation);
}

}  // namespace

std::int64_t Nanoseconds(double stamp_s) {
  if (!(stamp_s >= 0 && stamp_s < std::numeric_limits<std::int32_t>::max())) {
    throw InputError(fmt::format(
        "time {:.6f} s cannot be written to a bag, must be from 1970 to 2038", stamp_s));
  }
  // In two parts, because the product would be rounded to some hundred nanoseconds.
  const double whole = std::floor(stamp_s);
  return static_cast<std::int64_t>(whole) * kPerSecond +
         std::llround((stamp_s - whole) * static_cast<double>(kPerSecond));
}

std::vector<std::uint8_t> Encode(const ImageMessage& message) {
  CdrWriter out;
  out.Reserve(message.data.size() + 256);
  Put(message.header, out);
  out.Put(message.height);
  out.Put(message.width);
  out.PutText(message.encoding);
  out.Put(message.big_endian);
  out.Put(message.step);
  out.PutBytes(message.data);
  return out.Take();
}

std::vector<std::uint8_t> Encode(const CompressedImageMessage& message) {
  CdrWriter out;
  out.Reserve(message.data.size() + 256);
  Put(message.header, out);
  out.PutText(message.format);
  out.PutBytes(message.data);
  return out.Take();
}

std::vector<std::uint8_t> Encode(const CameraInfoMessage& message) {
  const auto& k = message.k;
  CdrWriter out;
  Put(message.header, out);
  out.Put(message.height);
  out.Put(message.width);
  out.PutText(message.distortion_model);
  out.PutCount(message.d.size());
  out.PutAll(message.d);
  out.PutAll(k);
  out.PutAll(std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1});
  out.PutAll(std::array<double, 12>{k[0], k[1], k[2], 0, k[3], k[4], k[5], 0, k[6], k[7], k[8], 0});
  // No binning; no region of interest: x, y, height, width, whether it is rectified.
  out.PutAll(std::array<std::uint32_t, 6>{});
  out.Put(false);
  return out.Take();
}

std::vector<std::uint8_t> Encode(const OdometryMessage& message) {
  CdrWriter out;
  Put(message.header, out);
  out.PutText(message.child_frame_id);
  Put(message.pose, out);
  out.PutAll(message.pose_covariance);
  out.PutAll(message.linear);
  out.PutAll(message.angular);
  out.PutAll(message.twist_covariance);
  return out.Take();
}

std::vector<std::uint8_t> Encode(const ImuMessage& message) {
  constexpr std::array<double, 9> kNotMeasured = {-1};
  CdrWriter out;
  Put(message.header, out);
  out.PutAll(Transform().rotation);
  out.PutAll(kNotMeasured);
  out.PutAll(message.angular_velocity);
  out.PutAll(std::array<double, 9>{});  // not known
  out.PutAll(std::array<double, 3>{});
  out.PutAll(kNotMeasured);
  return out.Take();
}

std::vector<std::uint8_t> Encode(const std::vector<TransformStamped>& transforms) {
  CdrWriter out;
  out.PutCount(transforms.size());
  for (const TransformStamped& transform : transforms) {
    Put(transform.header, out);
    out.PutText(transform.child_frame_id);
    Put(transform.transform, out);
  }
  return out.Take();
}

std::vector<std::uint8_t> Encode(const PoseMessage& message) {
  CdrWriter out;
  Put(message.header, out);
  Put(message.pose, out);
  out.PutAll(message.covariance);
  return out.Take();
}

std::vector<std::uint8_t> Encode(const PathMessage& message) {
  CdrWriter out;
  Put(message.header, out);
  out.PutCount(message.poses.size());
  for (const PathMessage::Pose& pose : message.poses) {
    Put(pose.header, out);
    Put(pose.pose, out);
  }
  return out.Take();
}

std::vector<std::uint8_t> Encode(const GridMessage& message) {
  CdrWriter out;
  out.Reserve(message.data.size() + 256);
  Put(message.header, out);
  Put(message.header.stamp_ns, out);  // map_load_time
  out.Put(message.resolution_m);
  out.Put(message.width);
  out.Put(message.height);
  Put(message.origin, out);
  out.PutBytes(message.data);
  return out.Take();
}

std::vector<std::uint8_t> Encode(const DiagnosticsMessage& message) {
  CdrWriter out;
  Put(message.header, out);
  out.PutCount(message.status.size());
  for (const DiagnosticsMessage::Status& status : message.status) {
    out.Put(static_cast<std::uint8_t>(status.level));
    out.PutText(status.name);
    out.PutText(status.message);
    out.PutText(status.hardware_id);
    out.PutCount(status.values.size());
    for (const auto& [key, value] : status.values) {
      out.PutText(key);
      out.PutText(value);
    }
  }
  return out.Take();
}

}  // namespace ceilmap::bags
