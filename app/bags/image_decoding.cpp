#include "app/bags/image_decoding.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>

#include "app/bags/message_error.hpp"
#include "calib/base/one_line.hpp"

namespace ceilmap::bags {
namespace {

constexpr std::uint32_t kMaxSidePx = 16384;  // as for the cameras of a rig
constexpr int kAsIs = -1;

// How OpenCV reads the pixels of an encoding. OpenCV names a Bayer pattern by the second and third
// pixel of the second row.
struct PixelLayout {
  std::string_view encoding;
  int type = CV_8UC1;
  int to_grey = kAsIs;
  int to_bgr = kAsIs;
};
constexpr std::array<PixelLayout, 22> kLayouts = {{
    {"mono8", CV_8UC1, kAsIs, cv::COLOR_GRAY2BGR},
    {"mono16", CV_16UC1, kAsIs, cv::COLOR_GRAY2BGR},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY, cv::COLOR_RGB2BGR},
    {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY, kAsIs},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY, cv::COLOR_RGBA2BGR},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2BGR},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY, cv::COLOR_YUV2BGR_UYVY},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2, cv::COLOR_YUV2BGR_YUY2},
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY, cv::COLOR_BayerGB2BGR},
    {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2GRAY, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2GRAY, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2GRAY, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2GRAY, cv::COLOR_BayerGB2BGR},
    {"8UC1", CV_8UC1, kAsIs, cv::COLOR_GRAY2BGR},
    {"8UC3", CV_8UC3, cv::COLOR_BGR2GRAY, kAsIs},
    {"16UC1", CV_16UC1, kAsIs, cv::COLOR_GRAY2BGR},
    // The names of ROS 2 since Jazzy.
    {"uyvy", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY, cv::COLOR_YUV2BGR_UYVY},
    {"yuyv", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2, cv::COLOR_YUV2BGR_YUY2},
    {"8UC4", CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2BGR},
}};

const PixelLayout& LayoutOf(const std::string& encoding) {
  const auto* const found = std::find_if(kLayouts.begin(), kLayouts.end(), [&](const auto& layout) {
    return layout.encoding == encoding;
  });
  if (found != kLayouts.end()) return *found;
  std::string known;
  for (const PixelLayout& layout : kLayouts) {
    known += (known.empty() ? "" : ", ") + std::string(layout.encoding);
  }
  throw MessageError(
      fmt::format("its encoding '{}' is not supported, must be one of {}", Shown(encoding), known));
}

void CheckSides(std::uint32_t width, std::uint32_t height) {
  if (width >= 1 && height >= 1 && width <= kMaxSidePx && height <= kMaxSidePx) return;
  throw MessageError(fmt::format(
      "is an image of {}x{} px, must have 1 to {} on a side", width, height, kMaxSidePx));
}

// Before a decoder takes memory. A byte of deflate gives at most 1032, that is 8256 px of one bit.
void CheckRatio(cv::Size size, std::size_t bytes) {
  constexpr std::uint64_t kMaxPxPerByte = 8256;
  const auto pixels =
      static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
  if (pixels <= kMaxPxPerByte * bytes) return;
  throw MessageError(fmt::format(
      "states an image of {}x{} px, which {} bytes cannot hold", size.width, size.height, bytes));
}

void CheckData(const ImageMessage& message, const PixelLayout& layout) {
  CheckSides(message.width, message.height);
  const std::uint64_t row = std::uint64_t{message.width} * CV_ELEM_SIZE(layout.type);
  if (message.step < row) {
    throw MessageError(fmt::format("its rows have {} bytes (step), but {} px of {} need {}",
                                   message.step,
                                   message.width,
                                   layout.encoding,
                                   row));
  }
  // The last row may be without its padding.
  const std::uint64_t least = std::uint64_t{message.step} * (message.height - 1) + row;
  if (message.data.size() < least) {
    throw MessageError(
        fmt::format("has {} bytes of pixels, but {}x{} px in rows of {} bytes need {}",
                    message.data.size(),
                    message.width,
                    message.height,
                    message.step,
                    least));
  }
  if (layout.type == CV_8UC2 && message.width % 2 != 0) {
    throw MessageError(fmt::format(
        "is an image of {} px width in {}, whose width is even", message.width, layout.encoding));
  }
}

// Sixteen-bit pixels as this machine stores them.
cv::Mat OrderedPixels(const ImageMessage& message, cv::Size size) {
  cv::Mat ordered(size, CV_16UC1);
  const std::size_t low = message.big_endian ? 1 : 0;
  for (int v = 0; v < ordered.rows; ++v) {
    const std::uint8_t* const from = message.data.data() + std::size_t{message.step} * v;
    auto* const to = ordered.ptr<std::uint16_t>(v);
    for (std::size_t u = 0; u < message.width; ++u) {
      to[u] = static_cast<std::uint16_t>(from[2 * u + 1 - low] << 8 | from[2 * u + low]);
    }
  }
  return ordered;
}

// The pixels of a message, without a copy where their bytes are in order.
cv::Mat StoredPixels(const ImageMessage& message, int type) {
  const cv::Size size(static_cast<int>(message.width), static_cast<int>(message.height));
  const bool native = message.big_endian == (std::endian::native == std::endian::big);
  const bool aligned =
      message.step % 2 == 0 && reinterpret_cast<std::uintptr_t>(message.data.data()) % 2 == 0;
  if (CV_MAT_DEPTH(type) == CV_16U && !(native && aligned)) return OrderedPixels(message, size);
  return {size, type, const_cast<std::uint8_t*>(message.data.data()), message.step};  // NOLINT
}

// To CV_8U, and by one of OpenCV's codes before it. The stored pixels do not change.
void ConvertPixels(const cv::Mat& stored, int code, cv::Mat& image) {
  constexpr double kSixteenToEightBits = 1.0 / 257;  // 65535 becomes 255
  const bool deep = stored.depth() == CV_16U;
  cv::Mat converted;
  if (code != kAsIs) cv::cvtColor(stored, deep ? converted : image, code);
  const cv::Mat& pixels = code != kAsIs ? converted : stored;
  if (deep) {
    pixels.convertTo(image, CV_8U, kSixteenToEightBits);
  } else if (code == kAsIs) {
    stored.copyTo(image);
  }
}

std::uint32_t BigEndianNumber(std::span<const std::uint8_t> bytes,
                              std::size_t at,
                              std::size_t size) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < size; ++i) number = number << 8U | bytes[at + i];
  return number;
}

// The size that a PNG states in its first chunk (IHDR).
cv::Size PngSize(std::span<const std::uint8_t> data) {
  constexpr std::size_t kWidthAt = 16;
  constexpr std::size_t kHeightAt = 20;
  if (data.size() < kHeightAt + 4) throw MessageError("is a PNG that ends early");
  const std::uint32_t width = BigEndianNumber(data, kWidthAt, 4);
  const std::uint32_t height = BigEndianNumber(data, kHeightAt, 4);
  CheckSides(width, height);
  return {static_cast<int>(width), static_cast<int>(height)};
}

// The size that a JPEG states in its frame header (SOF).
cv::Size JpegSize(std::span<const std::uint8_t> data) {
  constexpr std::size_t kHead = 4;  // marker (FF, code), length
  for (std::size_t at = 2; at + kHead + 5 <= data.size();) {
    if (data[at] != 0xFF) break;
    const int code = data[at + 1];
    if (code == 0xFF) {  // a filler
      ++at;
      continue;
    }
    const bool frame = code >= 0xC0 && code <= 0xCF && code != 0xC4 && code != 0xC8 && code != 0xCC;
    if (frame) {
      const std::uint32_t height = BigEndianNumber(data, at + kHead + 1, 2);
      const std::uint32_t width = BigEndianNumber(data, at + kHead + 3, 2);
      CheckSides(width, height);
      return {static_cast<int>(width), static_cast<int>(height)};
    }
    at += 2 + BigEndianNumber(data, at + 2, 2);
  }
  throw MessageError("is a JPEG that states no size");
}

bool BeginsWith(std::span<const std::uint8_t> data, std::string_view magic) {
  return data.size() >= magic.size() &&
         std::equal(magic.begin(), magic.end(), data.begin(), [](char a, std::uint8_t b) {
           return static_cast<std::uint8_t>(a) == b;
         });
}

cv::Mat DecodeCompressed(std::span<const std::uint8_t> data) {
  const cv::Mat bytes(1,
                      static_cast<int>(data.size()),
                      CV_8UC1,
                      const_cast<std::uint8_t*>(data.data()));  // NOLINT: not written to
  constexpr int kFlags = cv::IMREAD_ANYCOLOR | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION;
  try {
    return cv::imdecode(bytes, kFlags);
  } catch (const cv::Exception&) {
    return {};  // reported by the caller
  }
}

}  // namespace

void DecodePixels(const ImageMessage& message, bool colour, cv::Mat& image) {
  const PixelLayout& layout = LayoutOf(message.encoding);
  CheckData(message, layout);
  ConvertPixels(StoredPixels(message, layout.type), colour ? layout.to_bgr : layout.to_grey, image);
}

void DecodePixels(const CompressedImageMessage& message, bool colour, cv::Mat& image) {
  const bool png = BeginsWith(message.data, "\x89PNG\r\n\x1A\n");
  if (!png && !BeginsWith(message.data, "\xFF\xD8\xFF")) {
    throw MessageError(
        fmt::format("its format '{}' is neither JPEG nor PNG", Shown(message.format)));
  }
  const cv::Size size = png ? PngSize(message.data) : JpegSize(message.data);
  CheckRatio(size, message.data.size());
  const cv::Mat decoded = DecodeCompressed(message.data);
  if (decoded.empty() || decoded.size() != size) {
    throw MessageError(fmt::format("is a damaged {}", png ? "PNG" : "JPEG"));
  }
  const bool grey = decoded.channels() == 1;
  const int code = grey ? (colour ? cv::COLOR_GRAY2BGR : kAsIs)
                        : (colour ? kAsIs : static_cast<int>(cv::COLOR_BGR2GRAY));
  ConvertPixels(decoded, code, image);
}

}  // namespace ceilmap::bags
