#pragma once

#include <opencv2/core.hpp>

#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// The outlines of a mask, through the centres of its outermost pixels; parts that are narrower
/// than a pixel have none.
/// @param mask  CV_8UC1, its first pixel that of `grid`.
store::Polygons OutlinesOf(const cv::Mat& mask, const store::MosaicGrid& grid);

}  // namespace ceilmap::mosaic
