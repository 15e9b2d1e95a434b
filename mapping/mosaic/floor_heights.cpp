#include "mapping/mosaic/floor_heights.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace ceilmap::mosaic {
namespace {

constexpr int kTile = 256;  // side of the parts of HeightMap that are read at a time, pixels

/// Index of HeightMap's pixel that is nearest to each pixel of a window, along one axis.
/// @param first  distance of the window's first pixel centre from the outer edge of HeightMap's
/// first pixel, along the axis. @param step  between the window's pixels, same unit.
std::vector<int> NearestPixels(double first, double step, double resolution, int count) {
  std::vector<int> pixels(static_cast<std::size_t>(count));
  constexpr double kFar = 1e9;
  for (int i = 0; i < count; ++i) {
    const double at = std::floor((first + i * step) / resolution);
    pixels[static_cast<std::size_t>(i)] = static_cast<int>(std::clamp(at, -kFar, kFar));
  }
  return pixels;
}

/// Range [begin, end) of ascending pixels that are in [from, from + kTile).
std::array<int, 2> RangeIn(const std::vector<int>& pixels, int from) {
  const auto begin = std::lower_bound(pixels.begin(), pixels.end(), from);
  const auto end = std::lower_bound(begin, pixels.end(), from + kTile);
  return {static_cast<int>(begin - pixels.begin()), static_cast<int>(end - pixels.begin())};
}

}  // namespace

FloorHeights::FloorHeights(const std::vector<graph::Keyframe>& keyframes,
                           const store::MapMetadata& metadata)
    : metadata_(metadata) {
  if (!store::HeightAboveFloor(metadata, 1)) return;
  heights_ = HeightMap(keyframes, metadata);
  if (heights_.empty()) return;
  ceiling_ = CeilingExtent(keyframes, metadata, heights_);
  std::vector<graph::Keyframe> plane;
  for (const graph::Keyframe& keyframe : keyframes) {
    if (!keyframe.heights) plane.push_back(keyframe);
  }
  plane_views_ = PlaceViews(plane, metadata);
}

cv::Mat FloorHeights::PlaneMask(const store::MosaicGrid& grid, const cv::Rect& window) const {
  cv::Mat mask(window.size(), CV_8UC1, cv::Scalar(0));
  const cv::Rect2d area(grid.min_x + window.x * grid.resolution,
                        grid.max_y - window.br().y * grid.resolution,
                        window.width * grid.resolution,
                        window.height * grid.resolution);
  const double right = metadata_.view_size.width - 0.5;
  const double bottom = metadata_.view_size.height - 0.5;
  for (const ViewPlacement& view : plane_views_) {
    if ((view.Bounds() & area).empty()) continue;
    std::array<cv::Point, 4> outline;
    std::size_t i = 0;
    for (const cv::Point2d& corner : {view.ToMap(-0.5, -0.5),
                                      view.ToMap(right, -0.5),
                                      view.ToMap(right, bottom),
                                      view.ToMap(-0.5, bottom)}) {
      outline[i++] = cv::Point(cvRound((corner.x - area.x) / grid.resolution - 0.5),
                               cvRound((area.y + area.height - corner.y) / grid.resolution - 0.5));
    }
    cv::fillConvexPoly(mask, outline.data(), static_cast<int>(outline.size()), cv::Scalar(255));
  }
  return mask;
}

cv::Mat FloorHeights::Window(const store::MosaicGrid& grid, const cv::Rect& window) const {
  cv::Mat metres(window.size(), CV_32FC1, cv::Scalar(std::numeric_limits<float>::quiet_NaN()));
  if (empty() || window.empty()) return metres;
  const auto metres_of = [this](double rho) {
    return static_cast<float>(*store::HeightAboveFloor(metadata_, rho));
  };
  metres.setTo(metres_of(1), PlaneMask(grid, window));
  const store::MosaicGrid& from = heights_.Grid();
  const std::vector<int> cols =
      NearestPixels(grid.min_x + (window.x + 0.5) * grid.resolution - from.min_x,
                    grid.resolution,
                    from.resolution,
                    window.width);
  const std::vector<int> rows =
      NearestPixels(from.max_y - (grid.max_y - (window.y + 0.5) * grid.resolution),
                    grid.resolution,
                    from.resolution,
                    window.height);
  const int last_row = std::min(rows.back(), from.height_px - 1);
  const int last_col = std::min(cols.back(), from.width_px - 1);
  for (int y = std::max(rows.front(), 0); y <= last_row; y += kTile) {
    for (int x = std::max(cols.front(), 0); x <= last_col; x += kTile) {
      const auto [first_row, end_row] = RangeIn(rows, y);
      const auto [first_col, end_col] = RangeIn(cols, x);
      const cv::Mat rho = heights_.Ratios(
          {x, y, std::min(kTile, last_col + 1 - x), std::min(kTile, last_row + 1 - y)});
      for (int row = first_row; row < end_row; ++row) {
        for (int col = first_col; col < end_col; ++col) {
          const int v = rows[static_cast<std::size_t>(row)] - y;
          const int u = cols[static_cast<std::size_t>(col)] - x;
          if (v >= rho.rows || u >= rho.cols) continue;
          const float here = rho.at<float>(v, u);
          if (here > 0) metres.at<float>(row, col) = metres_of(here);
        }
      }
    }
  }
  const cv::Mat inside = ceiling_.Over(window, grid);
  if (!inside.empty()) metres.setTo(std::numeric_limits<float>::quiet_NaN(), inside == 0);
  return metres;
}

}  // namespace ceilmap::mosaic
