#pragma once

#include <algorithm>
#include <opencv2/core.hpp>

#include "mapping/mosaic/exposure.hpp"

namespace ceilmap::mosaic {

/// What every image has in common at a pixel: its weight in the mosaic, > 0 where the camera saw
/// anything, and exp(-v(r)), the factor that takes the vignetting out.
using Shading = cv::Vec2f;

/// Shading of all pixels of an image (CV_32FC2). The weight is (distance to the border of the
/// image or of what the camera saw of it)^power, 1 at its largest.
/// @param mask  CV_8UC1 of the size, not 0 where the camera saw anything; empty: everywhere.
cv::Mat MakeShading(cv::Size size,
                    const cv::Mat& mask,
                    double power,
                    const ExposureModel& exposure);

/// A grey value times the levelling factor, which may leave [0, 255]. Towards white a pixel counts
/// more and more as saturated: its true brightness is unknown and it is not darkened, so that a
/// white lamp does not turn grey.
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
