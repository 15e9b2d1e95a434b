#pragma once

#include <opencv2/core.hpp>

namespace ceilmap::registration {

/// Noise of an image, standard deviations in grey levels.
struct ImageNoise {
  float white = 0;  ///< of white noise (EstimateNoise)
  /// With the error of the codec, where the image was encoded; otherwise `white`. A codec removes
  /// weak content at high spatial frequencies, and what is left there is mostly its error: the less
  /// white noise is left, the coarser the codec was.
  float coded = 0;
  /// Fraction of a sensor's white noise that a codec or a denoiser removed, 0..1.
  float removed = 0;

  /// Less white noise than any camera's sensor has: encoded at a low bitrate, or denoised.
  [[nodiscard]] bool IsEncoded() const { return removed > 0; }
  /// Of the image reduced by this factor.
  [[nodiscard]] ImageNoise Reduced(double factor) const;
};

/// Standard deviation of white noise in an image, in grey levels, from the median of its mixed
/// second differences (texture increases it a little; at least 0.3, the rounding to 8 bits, and not
/// more where three quarters are black or white). @param grey  CV_8UC1.
float EstimateNoise(const cv::Mat& grey);

/// @param white  EstimateNoise.
ImageNoise MakeNoise(float white);

/// Power of the white noise that two images have in common, grey levels squared.
double WhitePower(const ImageNoise& a, const ImageNoise& b);

/// The same with the error of the codec. A codec encodes all images of a video: where only one has
/// little noise, that one is blurred by motion, and the result is WhitePower.
double CodedPower(const ImageNoise& a, const ImageNoise& b);

}  // namespace ceilmap::registration
