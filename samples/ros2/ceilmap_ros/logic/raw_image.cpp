#include "ceilmap_ros/logic/raw_image.hpp"

#include <fmt/format.h>

#include <array>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "calib/base/error.hpp"

namespace ceilmap_ros {
namespace {

using ceilmap::InputError;

constexpr int kNone = -1;
// Rows of 16 bit pixels may begin at odd addresses.
constexpr int kTwoBytes = CV_8UC2;

/// How an encoding becomes grey or BGR; kNone: as it is.
struct Encoding {
  std::string_view name;
  int type = CV_8UC1;
  int to_grey = kNone;
  int to_bgr = kNone;
};

// OpenCV names a Bayer pattern by the second row from its second pixel on, ROS by the first row.
constexpr std::array kEncodings{
    Encoding{"mono8", CV_8UC1},
    Encoding{"8UC1", CV_8UC1},
    Encoding{"mono16", kTwoBytes},
    Encoding{"16UC1", kTwoBytes},
    Encoding{"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY, cv::COLOR_RGB2BGR},
    Encoding{"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY, kNone},
    Encoding{"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY, cv::COLOR_RGBA2BGR},
    Encoding{"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2BGR},
    Encoding{"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY, cv::COLOR_BayerBG2BGR},
    Encoding{"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY, cv::COLOR_BayerRG2BGR},
    Encoding{"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY, cv::COLOR_BayerGR2BGR},
    Encoding{"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY, cv::COLOR_BayerGB2BGR},
};

const Encoding& Find(const std::string& name) {
  for (const Encoding& encoding : kEncodings) {
    if (encoding.name == name) return encoding;
  }
  throw InputError(
      fmt::format("the encoding '{}' is not supported, must be mono8, mono16, rgb8, bgr8, rgba8, "
                  "bgra8 or bayer_*8; set it in the camera's driver",
                  name));
}

}  // namespace

cv::Mat Decode(const RawImage& image, Colours colours) {
  const Encoding& encoding = Find(image.encoding);
  // Demosaicing needs a few rows, and OpenCV counts bytes of rows as int.
  constexpr std::uint32_t kMinSide = 8;
  constexpr std::uint32_t kMaxSide = 1U << 15;
  const std::size_t row_bytes = std::size_t{image.width} * CV_ELEM_SIZE(encoding.type);
  const bool complete = image.width >= kMinSide && image.height >= kMinSide &&
                        image.width <= kMaxSide && image.height <= kMaxSide &&
                        image.step >= row_bytes &&
                        image.data.size() >= std::size_t{image.step} * image.height;
  if (!complete) {
    throw InputError(
        fmt::format("an image of {}x{} px ({}) with rows of {} bytes has {} bytes; "
                    "the camera's driver writes a wrong header",
                    image.width,
                    image.height,
                    image.encoding,
                    image.step,
                    image.data.size()));
  }
  // OpenCV takes no pointer to constant data; nothing writes there.
  const cv::Mat raw(static_cast<int>(image.height),
                    static_cast<int>(image.width),
                    encoding.type,
                    const_cast<std::uint8_t*>(image.data.data()),
                    image.step);
  if (encoding.type == kTwoBytes) {
    cv::Mat upper;
    cv::extractChannel(raw, upper, image.is_bigendian ? 0 : 1);
    return upper;
  }
  const bool keep_colours = colours == Colours::kIfItHasAny && encoding.to_grey != kNone;
  const int conversion = keep_colours ? encoding.to_bgr : encoding.to_grey;
  if (conversion == kNone) return raw.clone();
  cv::Mat converted;
  cv::cvtColor(raw, converted, conversion);
  return converted;
}

}  // namespace ceilmap_ros
