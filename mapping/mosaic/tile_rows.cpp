#include "mapping/mosaic/tile_rows.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::mosaic {
namespace {

/// Narrows [first, last) to the columns where lowest <= start + column * step <= limit.
void Clip(double start, double step, double lowest, double limit, int& first, int& last) {
  constexpr double kSlack = 1e-6;  // pixels; centres exactly on the border count as inside
  if (std::abs(step) < 1e-12) {
    if (start < lowest - kSlack || start > limit + kSlack) last = first;
    return;
  }
  double low = (lowest - kSlack - start) / step;
  double high = (limit + kSlack - start) / step;
  if (low > high) std::swap(low, high);
  const double columns = last;
  first = std::max(first, static_cast<int>(std::ceil(std::clamp(low, 0.0, columns))));
  last = std::min(last, static_cast<int>(std::floor(std::clamp(high, -1.0, columns - 1))) + 1);
}

}  // namespace

RowMap MapRow(const ViewPlacement& view,
              cv::Size view_size,
              const store::MosaicGrid& grid,
              const cv::Rect& tile,
              int row,
              const TileRatios& ratios) {
  const double x = grid.min_x + 0.5 * grid.resolution;
  const double y = grid.max_y - (tile.y + row + 0.5) * grid.resolution;
  RowMap map;
  map.start = view.ToPixel(x, y);
  map.step = view.ToPixel(x + grid.resolution, y) - map.start;
  map.first = tile.x;
  map.last = tile.x + tile.width;
  // The pixel moves along the line through the principal point, by the factor rho.
  const auto clip = [&](double start, double step, double limit, double principal) {
    double low = 0;
    double high = limit;
    if (!ratios.rho.empty()) {
      const auto plane = [&](double at, double rho) { return principal + (at - principal) / rho; };
      low = std::min(plane(0, ratios.min), plane(0, ratios.max));
      high = std::max(plane(limit, ratios.min), plane(limit, ratios.max));
    }
    Clip(start, step, low, high, map.first, map.last);
  };
  clip(map.start.x, map.step.x, view_size.width - 1, view.Principal().x);
  clip(map.start.y, map.step.y, view_size.height - 1, view.Principal().y);
  return map;
}

}  // namespace ceilmap::mosaic
