#pragma once

#include <opencv2/core.hpp>

#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// Inverse height ratios of a tile's pixels.
struct TileRatios {
  /// @param ratios  CV_32FC1 of the tile's size; no matrix: all are 1.
  explicit TileRatios(const cv::Mat& ratios) : rho(ratios) {
    if (!rho.empty()) cv::minMaxLoc(rho, &min, &max);
  }
  cv::Mat rho;
  double min = 1;
  double max = 1;
};

/// Pixels of an image along one row of the mosaic: on the reference plane (u, v) = start + column *
/// step, for the columns [first, last) of a tile that can lie inside the image.
struct RowMap {
  cv::Point2d start;
  cv::Point2d step;
  int first = 0;
  int last = 0;
};

/// Anchored at the mosaic's origin, not at the tile's, so that the value of a point does not depend
/// on the rendered window.
/// @param row  of the tile.
RowMap MapRow(const ViewPlacement& view,
              cv::Size view_size,
              const store::MosaicGrid& grid,
              const cv::Rect& tile,
              int row,
              const TileRatios& ratios);

}  // namespace ceilmap::mosaic
