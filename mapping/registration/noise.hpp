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
  bool predicted = false;  ///< Encoding::predicted

  /// Less white noise than any camera's sensor has: encoded at a low bitrate, or denoised.
  [[nodiscard]] bool IsEncoded() const { return removed > 0; }
  /// Of the image reduced by this factor.
  [[nodiscard]] ImageNoise Reduced(double factor) const;
};

/// Standard deviation of white noise in an image, in grey levels, from the median of its mixed
/// second differences (texture increases it a little; at least 0.3, the rounding to 8 bits, and not
/// more where three quarters are black or white). @param grey  CV_8UC1.
float EstimateNoise(const cv::Mat& grey);

/// White noise of any camera's sensor, grey levels: videos of x264 have less from CRF 25 to 30 on.
inline constexpr float kSensorNoise = 1;

/// @param white  EstimateNoise. @param sensor  What is left of kSensorNoise in such an image.
ImageNoise MakeNoise(float white, float sensor = kSensorNoise);

/// Power of the white noise that two images have in common, grey levels squared.
double WhitePower(const ImageNoise& a, const ImageNoise& b);

/// Whether the error of a codec counts in the comparison of two images. It encodes all images of a
/// video: where only one has little noise, that one is blurred by motion. A reference of another
/// recording (RegistrarParams::same_recording) is drawn from a map and has little noise without any
/// codec, so that the current image alone tells: it must be coarse, of a codec that predicts.
bool CodecCounts(const ImageNoise& reference, const ImageNoise& current, bool same_recording);

/// WhitePower, or where CodecCounts the power of what the codec's errors have in common; those of
/// an image drawn from a map are taken to be as large as those of the current image.
double CodedPower(const ImageNoise& reference, const ImageNoise& current, bool same_recording);

}  // namespace ceilmap::registration
