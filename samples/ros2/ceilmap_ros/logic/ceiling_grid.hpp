#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/store/map_file.hpp"

namespace ceilmap_ros {

/// A mosaic of the ceiling in the form of a nav_msgs/OccupancyGrid, to be looked at: it shows the
/// ceiling, not obstacles.
struct CeilingGrid {
  double resolution_m = 0;
  double origin_x_m = 0;  ///< of the lower left corner
  double origin_y_m = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  /// Rows from the smallest y on. 0: white, 100: black, -1: not mapped.
  std::vector<std::int8_t> cells;
};

/// @param grey, alpha  CV_8UC1 of the grid's size, row 0 at the largest y.
CeilingGrid ToCeilingGrid(const ceilmap::store::MosaicGrid& grid,
                          const cv::Mat& grey,
                          const cv::Mat& alpha);

/// @param max_px  longest side, >= 1.
CeilingGrid ReadCeilingGrid(const ceilmap::store::MapReader& map, int max_px);

}  // namespace ceilmap_ros
