#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/mosaic/exposure.hpp"
#include "mapping/mosaic/height_map.hpp"
#include "mapping/mosaic/view_placement.hpp"

namespace ceilmap::mosaic {

/// Observations of the brightness of a lattice of ceiling points in the images, for SolveExposure.
/// A point counts where its patch in the image is flat but for the image's noise: saturated (>=
/// 250) and dark (<= 3) pixels give no ratio, and at an edge a small error of the pose would be
/// taken for one of the exposure.
///
/// Views that do not see the point, because a nearer surface hides it, are left out.
///
/// @param row_times  See RowTimes; empty: rows were exposed at once.
/// @param load  image of the view with that index, CV_8UC1 of `size`; each image is loaded once.
std::vector<ExposureObservation> ObserveExposure(const std::vector<ViewPlacement>& views,
                                                 cv::Size size,
                                                 double units_per_px,
                                                 const HeightMap& heights,
                                                 const cv::Mat& row_times,
                                                 const std::function<cv::Mat(std::size_t)>& load);

}  // namespace ceilmap::mosaic
