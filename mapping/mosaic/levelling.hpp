#pragma once

#include <algorithm>
#include <opencv2/core.hpp>

#include "mapping/mosaic/exposure.hpp"

namespace ceilmap::mosaic {

/// Pixel properties that all images share: the weight in the mosaic, > 0 where the camera saw
/// anything, and exp(-v(r)), the factor that removes the vignetting.
using Shading = cv::Vec2f;

/// Shading of all pixels of an image (CV_32FC2). The weight is (distance to the border of the image
/// or of its content)^power, scaled to a maximum of 1.
/// @param mask  CV_8UC1 of the size, not 0 where the camera saw anything; empty: everywhere.
cv::Mat MakeShading(cv::Size size,
                    const cv::Mat& mask,
                    double power,
                    const ExposureModel& exposure);

/// A grey value times the levelling factor; the result may leave [0, 255]. Near white a pixel is
/// increasingly treated as saturated: its true brightness is unknown and it is not darkened, so
/// that a white lamp does not turn grey.
inline float LevelGrey(float grey, float factor) {
  constexpr float kSaturationStart = 240;
  constexpr float kSaturationEnd = 252;
  const float levelled = grey * factor;
  if (grey <= kSaturationStart) return levelled;
  const float saturated =
      std::min((grey - kSaturationStart) / (kSaturationEnd - kSaturationStart), 1.0F);
  return levelled + saturated * std::max(grey - levelled, 0.0F);
}

}  // namespace ceilmap::mosaic
