#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "app/bags/mcap_writer.hpp"
#include "app/bags/message_encoding.hpp"
#include "app/bags/message_types.hpp"

/// One message of each type that ceilmap writes, with a different value in each field.
namespace ceilmap::bags {

inline const Header kHeader{1'700'000'000'123'456'789, "frame"};
inline const Transform kTransform{{1.5, -2.25, 3.125}, {0.5, -0.5, 0.5, -0.5}};
inline const std::vector<std::uint8_t> kPixels = {0, 1, 127, 128, 254, 255};

template <std::size_t N>
std::array<double, N> Counted(double first) {
  std::array<double, N> numbers{};
  for (std::size_t i = 0; i < N; ++i) numbers[i] = first + 0.25 * static_cast<double>(i);
  return numbers;
}

inline ImageMessage AnImage() {
  return {kHeader, 2, 3, "mono8", false, 3, kPixels};
}
inline CompressedImageMessage ACompressedImage() {
  return {kHeader, "jpeg", kPixels};
}
inline CameraInfoMessage ACameraInfo() {
  return {kHeader, 480, 640, "plumb_bob", {-0.3, 0.1, 0.001, -0.002, 0.05}, Counted<9>(300)};
}
inline OdometryMessage AnOdometry() {
  return {kHeader,
          "child",
          kTransform,
          Counted<36>(1),
          {0.1, 0.2, 0.3},
          {0.4, 0.5, 0.6},
          Counted<36>(-50)};
}
inline ImuMessage AnImu() {
  return {kHeader, {0.01, -0.02, 0.03}};
}
inline std::vector<TransformStamped> TwoTransforms() {
  std::vector<TransformStamped> transforms(2, {kHeader, "child", kTransform});
  transforms[1].header = {7'000'000'001, "x"};
  transforms[1].child_frame_id = "a longer name";
  return transforms;
}
inline PoseMessage APose() {
  return {kHeader, kTransform, Counted<36>(1)};
}
inline PathMessage APath() {
  return {kHeader, {{{1, ""}, kTransform}, {kHeader, Transform()}}};
}
inline GridMessage AGrid() {
  return {kHeader, 0.05F, 2, 3, kTransform, {0, 1, 50, 99, 100, 255}};
}
inline DiagnosticsMessage SomeDiagnostics() {
  using Level = DiagnosticsMessage::Level;
  return {kHeader,
          {{Level::kOk, "localization", "tracking", "camera", {{"peak", "0.512"}, {"empty", ""}}},
           {Level::kError, "second", "", "", {}}}};
}

/// Writes each of them on a topic of its own, one millisecond apart.
inline void WriteAllMessages(McapWriter& writer) {
  std::int64_t time_ns = kHeader.stamp_ns;
  const auto write = [&](const char* topic, std::string_view type, const auto& message) {
    writer.Write(writer.Add(topic, type), time_ns, Encode(message));
    time_ns += 1'000'000;
  };
  write("/image", kImageType, AnImage());
  write("/compressed", kCompressedImageType, ACompressedImage());
  write("/camera_info", kCameraInfoType, ACameraInfo());
  write("/odom", kOdometryType, AnOdometry());
  write("/imu", kImuType, AnImu());
  write("/tf", kTransformsType, TwoTransforms());
  write("/pose", kPoseType, APose());
  write("/path", kPathType, APath());
  write("/map", kGridType, AGrid());
  write("/diagnostics", kDiagnosticsType, SomeDiagnostics());
}

}  // namespace ceilmap::bags
