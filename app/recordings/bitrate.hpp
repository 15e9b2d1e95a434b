#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace ceilmap::recordings {

/// Size of a video file per pixel of its frames, bits: how strongly it is compressed. Nothing for
/// folders, bags, pipes, cameras and streams.
/// @param frames  of the file. @param size  of a frame.
std::optional<double> BitsPerPixel(const std::string& source, std::int64_t frames, cv::Size size);

/// What a video spends on each pixel: mean over its last seconds, so that one image that depends on
/// no other, and many small ones after it, count together.
class PixelRate {
 public:
  /// @param period_s  of the images, > 0; nothing: unknown, and so is the rate.
  PixelRate(std::optional<double> period_s, cv::Size size);
  /// Adds the next image of the file or stream. @param bytes  its size, >= 0.
  void Add(std::int64_t bytes);
  /// Bits per second and pixel; 0: unknown.
  [[nodiscard]] double BitsPerSecond() const;

 private:
  double period_s_;
  double pixels_;
  std::size_t window_ = 0;          // images
  std::deque<std::int64_t> bytes_;  // of the images in the window
  std::int64_t sum_ = 0;
};

}  // namespace ceilmap::recordings
