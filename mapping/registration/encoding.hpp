#pragma once

#include <opencv2/core.hpp>
#include <optional>

namespace ceilmap::registration {

/// How a camera's image was encoded before it was drawn for registration.
struct Encoding {
  /// By a codec that predicts parts of images from other images, and smooths what it cannot afford
  /// (H.264, VP8, VP9, AV1): its errors move with the ceiling, and the noise that is left tells how
  /// large they are. Not H.265, whose coarse images keep noise, not MJPEG, and not a raw image.
  bool predicted = false;
  /// What the video spent on each pixel in the last seconds, bits per second: an image to which a
  /// coarse codec added next to nothing shows the ceiling as it was before. 0: unknown, or not a
  /// video.
  double pixel_rate_bit_s = 0;
  /// FrameSpectrum::SmoothingLoss of the image from which this one was drawn level, which smoothed
  /// its noise; nothing: estimated in this one.
  std::optional<double> loss = std::nullopt;
  /// FrameSpectrum::CodingLoss: that of the image as the camera took it, before it was rectified
  /// (LossAsTaken); nothing: it is this image.
  std::optional<double> loss_as_taken = std::nullopt;
};

/// Encoding::loss_as_taken of an image that will be rectified, which smooths its noise as a codec
/// does. @param grey  CV_8UC1, as the camera took it.
double LossAsTaken(const cv::Mat& grey);

}  // namespace ceilmap::registration
