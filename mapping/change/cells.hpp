#pragma once

#include <opencv2/core.hpp>

#include "mapping/store/map_file.hpp"

namespace ceilmap::change {

/// Changes are decided for square cells of the mosaic, this many pixels wide. Only whole cells
/// count. Cells are numbered from the upper left corner of the mosaic: (column, row).
inline constexpr int kCellPx = 16;

/// All cells of a mosaic.
inline cv::Rect CellsOf(const store::MosaicGrid& grid) {
  return {0, 0, grid.width_px / kCellPx, grid.height_px / kCellPx};
}

/// Pixels of the mosaic.
inline cv::Rect PixelsOf(const cv::Rect& cells) {
  return {cells.x * kCellPx, cells.y * kCellPx, cells.width * kCellPx, cells.height * kCellPx};
}

/// Area of one cell, map units^2.
inline double CellArea(const store::MosaicGrid& grid) {
  return kCellPx * grid.resolution * kCellPx * grid.resolution;
}

}  // namespace ceilmap::change
