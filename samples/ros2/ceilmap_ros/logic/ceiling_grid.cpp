#include "ceilmap_ros/logic/ceiling_grid.hpp"

namespace ceilmap_ros {

namespace store = ceilmap::store;

CeilingGrid ToCeilingGrid(const store::MosaicGrid& grid,
                          const cv::Mat& grey,
                          const cv::Mat& alpha) {
  CeilingGrid ceiling;
  ceiling.resolution_m = grid.resolution;
  ceiling.origin_x_m = grid.min_x;
  ceiling.origin_y_m = grid.max_y - grid.resolution * grid.height_px;
  ceiling.width = static_cast<std::uint32_t>(grid.width_px);
  ceiling.height = static_cast<std::uint32_t>(grid.height_px);
  ceiling.cells.reserve(std::size_t{ceiling.width} * ceiling.height);
  for (int row = grid.height_px - 1; row >= 0; --row) {
    const auto* values = grey.ptr<std::uint8_t>(row);
    const auto* known = alpha.ptr<std::uint8_t>(row);
    for (int col = 0; col < grid.width_px; ++col) {
      const int darkness = (100 * (255 - values[col]) + 127) / 255;
      ceiling.cells.push_back(static_cast<std::int8_t>(known[col] == 0 ? -1 : darkness));
    }
  }
  return ceiling;
}

CeilingGrid ReadCeilingGrid(const store::MapReader& map, int max_px) {
  cv::Mat grey;
  cv::Mat alpha;
  const store::MosaicGrid grid = map.ReadOverview(max_px, grey, alpha);
  return ToCeilingGrid(grid, grey, alpha);
}

}  // namespace ceilmap_ros
