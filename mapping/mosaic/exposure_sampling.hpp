#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/mosaic/exposure.hpp"
#include "mapping/mosaic/view_placement.hpp"

namespace ceilmap::mosaic {

/// What the images say about the brightness of a lattice of ceiling points, for SolveExposure.
/// A point counts where its patch in the image is flat: saturated (>= 250) and dark (<= 3) pixels
/// tell no ratio, and across an edge a small error of the pose would look like one of the exposure.
///
/// @param load  image of the view with that index, CV_8UC1 of `size`; each is asked for once.
std::vector<ExposureObservation> ObserveExposure(const std::vector<ViewPlacement>& views,
                                                 cv::Size size,
                                                 double units_per_px,
                                                 const std::function<cv::Mat(std::size_t)>& load);

}  // namespace ceilmap::mosaic
