#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

extern "C" {
#include <libavutil/pixfmt.h>
#include <libavutil/rational.h>
}

namespace ceilmap::support {

/// How WriteEncoded stores a video. The container follows from the file's extension.
struct Encoding {
  std::string codec = "ffv1";
  AVPixelFormat format = AV_PIX_FMT_YUV420P;        ///< 8 bits, luma in its own plane
  std::map<std::string, std::string> options = {};  ///< of the encoder
  AVRational sample_aspect = {0, 1};
  std::optional<std::array<std::int32_t, 9>> display_matrix = {};
  bool interlaced = false;
  bool wrong_field_order = false;  ///< the container states fields, the images are progressive
  std::vector<std::int64_t> times = {};  ///< tenths of a second; empty: 0, 1, 2, ...
};

/// Stores luma of limited range and neutral chroma with FFmpeg's encoders.
/// @param images  CV_8UC1, of one size. @throws std::runtime_error when an encoder is missing.
void WriteEncoded(const std::filesystem::path& file,
                  const Encoding& encoding,
                  const std::vector<cv::Mat>& images);

}  // namespace ceilmap::support
