#pragma once

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
  /// FrameSpectrum::CodingLoss of the image from which this one was drawn anew, which smoothed its
  /// noise; nothing: estimated in this one.
  std::optional<double> loss = std::nullopt;
};

}  // namespace ceilmap::registration
