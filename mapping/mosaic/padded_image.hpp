#pragma once

#include <opencv2/core.hpp>

namespace ceilmap::mosaic {

/// Rows and columns repeated around a cached image, so that sampling needs no border checks.
inline constexpr int kPadding = 2;

/// Bilinear grey at a pixel of a padded image (CV_8UC1). @param pixel  of the image without
/// padding, inside of it.
inline float Sample(const cv::Mat& padded, const cv::Point2d& pixel) {
  const int iu = static_cast<int>(pixel.x);
  const int iv = static_cast<int>(pixel.y);
  const auto fu = static_cast<float>(pixel.x - iu);
  const auto fv = static_cast<float>(pixel.y - iv);
  const unsigned char* top = padded.ptr<unsigned char>(iv + kPadding) + iu + kPadding;
  const unsigned char* bottom = top + padded.step[0];
  const auto upper = static_cast<float>(top[0]) + fu * static_cast<float>(top[1] - top[0]);
  const auto lower = static_cast<float>(bottom[0]) + fu * static_cast<float>(bottom[1] - bottom[0]);
  return upper + fv * (lower - upper);
}

/// Whether Sample would include pixels without content.
inline bool TouchesBlank(const cv::Mat& padded, const cv::Point2d& pixel) {
  const unsigned char* top = padded.ptr<unsigned char>(static_cast<int>(pixel.y) + kPadding) +
                             static_cast<int>(pixel.x) + kPadding;
  const unsigned char* bottom = top + padded.step[0];
  return top[0] == 0 || top[1] == 0 || bottom[0] == 0 || bottom[1] == 0;
}

}  // namespace ceilmap::mosaic
