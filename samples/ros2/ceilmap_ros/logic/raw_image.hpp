#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>

namespace ceilmap_ros {

/// The content of a sensor_msgs/Image.
struct RawImage {
  std::string encoding;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t step = 0;  ///< bytes of a row
  bool is_bigendian = false;
  std::span<const std::uint8_t> data;
};

enum class Colours {
  kGrey,        ///< CV_8UC1
  kIfItHasAny,  ///< CV_8UC3 (BGR) of an image in colour, otherwise CV_8UC1
};

/// The pixels as ceilmap::robot takes them, in memory of their own. Encodings: mono8, 8UC1, mono16,
/// 16UC1, rgb8, bgr8, rgba8, bgra8, and bayer_*8.
/// @throws InputError on another encoding, or when the data are shorter than width, height and step
///   state. The message names the encoding and what helps.
cv::Mat Decode(const RawImage& image, Colours colours);

}  // namespace ceilmap_ros
