#pragma once

#include <opencv2/core.hpp>

namespace ceilmap::mosaic {

/// How well the images of one place agree if its inverse height ratio is a given value.
class RatioCost {
 public:
  RatioCost() = default;
  RatioCost(const RatioCost&) = delete;
  RatioCost& operator=(const RatioCost&) = delete;
  virtual ~RatioCost() = default;
  /// Chooses the images that are compared at the pixel (col, row) of the raster.
  /// @param rho  approximate ratio of the place, > 0.
  virtual void Select(int col, int row, float rho) = 0;
  /// Disagreement of these images in [0, 1] if the ratio is rho; 0: they are equal.
  [[nodiscard]] virtual float Cost(float rho) const = 0;
};

/// Refines a raster of inverse height ratios by the images. Each pixel takes the ratio, among those
/// of its neighbours, the reference plane (1) and small changes of its own, whose cost is least:
/// disagreement of the images, plus a constant for each neighbour that is of another surface, plus
/// a constant for a surface other than that of `ratios`. Edges of surfaces move from the blocks
/// that were measured to where the images show them, and places without texture take the ratio of
/// their surroundings. A fixed number of passes; a pixel depends on the pixels within
/// kRefinementReach only. (PatchMatch: Barnes et al. 2009, Bleyer et al. 2011, with passes that all
/// pixels do at once.)
///
/// @param ratios  CV_32FC1, a part of the raster; 0, not known, stays. @param first  its first
/// pixel.
void RefineRatios(cv::Mat& ratios, const cv::Point& first, RatioCost& cost);
inline constexpr int kRefinementReach = 10;

}  // namespace ceilmap::mosaic
