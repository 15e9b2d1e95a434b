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
  /// Fraction of a sensor's white noise that is missing in this image, 0..1: removed by a codec or
  /// a denoiser, or smoothed when the image was drawn from another one (rectified). It measures the
  /// errors at high spatial frequencies, which all of these make.
  float removed = 0;
  /// ... in the image as the camera took it (Encoding::loss_as_taken): by a codec or a denoiser
  /// alone. Only a codec leaves less evidence in an image, and copies parts of it.
  float removed_as_taken = 0;
  bool predicted = false;  ///< Encoding::predicted

  /// Less white noise than any camera's sensor has.
  [[nodiscard]] bool IsSmooth() const { return removed > 0; }
  /// ... as the camera took it: encoded at a low bitrate, denoised, or blurred by motion.
  [[nodiscard]] bool IsEncoded() const { return removed_as_taken > 0; }
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

/// Whether the images are encoded, so that less evidence is enough. A codec encodes all images of a
/// video: where only one has little noise, that one is blurred by motion. A reference of another
/// recording (RegistrarParams::same_recording) is drawn from a map and has little noise without any
/// codec, so that the current image alone tells: it must be coarse, of a codec that predicts.
bool CodecCounts(const ImageNoise& reference, const ImageNoise& current, bool same_recording);

/// Whether errors at high spatial frequencies count in the comparison of two images: those of a
/// codec, or of drawing (rectified images).
bool SmoothingCounts(const ImageNoise& reference, const ImageNoise& current, bool same_recording);

/// WhitePower, or where SmoothingCounts the power of what these errors have in common; those of an
/// image drawn from a map are taken to be as large as those of the current image.
double CodedPower(const ImageNoise& reference, const ImageNoise& current, bool same_recording);

/// CodedPower, without what motion blur took from one of two rectified images: drawing takes the
/// same from all of them, and that is what the sharper one lost.
double CommonPower(const ImageNoise& reference, const ImageNoise& current, bool same_recording);

}  // namespace ceilmap::registration
