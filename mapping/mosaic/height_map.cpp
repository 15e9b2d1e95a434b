#include "mapping/mosaic/height_map.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/mosaic/surface_votes.hpp"
#include "mapping/store/map_metadata.hpp"

namespace ceilmap::mosaic {
namespace {

// Pixels of the raster across one step of a height field of blocks; at least so many pixels of an
// image.
constexpr double kCellsPerStep = 4;
constexpr double kMinCellPx = 4;
/// Radius in which a block votes, steps of its field. Blocks overlap by half: its side is two.
constexpr double kReach = 1.0;
constexpr double kAccurate = 0.01;  // standard deviation of a vote of weight 1 ...
constexpr double kWeak = 0.02;      // ... and of the least one: saturated lamps are surfaces too

/// Calls visit(p_map, cell, step) for each measured cell; steps of its field in map units.
template <typename Visit>
void ForEachPoint(const std::vector<graph::Keyframe>& keyframes,
                  const store::MapMetadata& metadata,
                  const Visit& visit) {
  const std::vector<ViewPlacement> views = PlaceViews(keyframes, metadata);
  const cv::Point2d centre((metadata.view_size.width - 1) / 2.0,
                           (metadata.view_size.height - 1) / 2.0);
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    if (!keyframes[k].heights) continue;
    const heights::HeightField& field = *keyframes[k].heights;
    const double step = field.step_px.minCoeff() * metadata.view_units_per_px;
    for (std::size_t i = 0; i < field.cells.size(); ++i) {
      const heights::HeightCell& cell = field.cells[i];
      if (!(cell.sigma < heights::kMeasuredSigma) || !(cell.rho > 0)) continue;
      const Eigen::Vector2d at = field.Centre(i);
      visit(views[k].ToMap(centre.x + at.x(), centre.y + at.y(), cell.rho), cell, step);
    }
  }
}

/// Smallest distance of the cells of the height fields, map units; 0: there are none.
double FinestStep(const std::vector<graph::Keyframe>& keyframes,
                  const store::MapMetadata& metadata) {
  double finest = 0;
  for (const graph::Keyframe& keyframe : keyframes) {
    if (!keyframe.heights) continue;
    const double step = keyframe.heights->step_px.minCoeff() * metadata.view_units_per_px;
    finest = finest == 0 ? step : std::min(finest, step);
  }
  return finest;
}

/// Extent of a raster; without pixels where nothing is known, or the numbers are no usable ones.
store::MosaicGrid GridOf(const std::vector<graph::Keyframe>& keyframes,
                         const store::MapMetadata& metadata) {
  const double finest = FinestStep(keyframes, metadata);
  cv::Point2d low;
  cv::Point2d high;
  bool first = true;
  ForEachPoint(keyframes,
               metadata,
               [&](const cv::Point2d& at, const heights::HeightCell& /*cell*/, double /*step*/) {
                 low = first ? at : cv::Point2d(std::min(low.x, at.x), std::min(low.y, at.y));
                 high = first ? at : cv::Point2d(std::max(high.x, at.x), std::max(high.y, at.y));
                 first = false;
               });
  if (first || !(finest > 0)) return {};
  constexpr double kMargin = SurfaceVotes::kMaxRadius + kFillReach;
  constexpr double kMaxPixels = 1e9;
  store::MosaicGrid grid;
  grid.resolution = std::max(finest / kCellsPerStep, kMinCellPx * metadata.view_units_per_px);
  grid.min_x = (std::floor(low.x / grid.resolution) - kMargin) * grid.resolution;
  grid.max_y = (std::ceil(high.y / grid.resolution) + kMargin) * grid.resolution;
  const auto pixels = [&](double length) {
    return static_cast<int>(std::min(std::ceil(length / grid.resolution) + kMargin, kMaxPixels));
  };
  grid.width_px = pixels(high.x - grid.min_x);
  grid.height_px = pixels(grid.max_y - low.y);
  return store::Problem(grid).empty() ? grid : store::MosaicGrid();
}

/// The ratio at a position of the raster, 0: not known. @param value  (col, row) of the raster.
template <typename Value>
float Interpolate(float x, float y, const Value& value) {
  const float nearest = value(cvRound(x), cvRound(y));
  if (nearest <= 0) return 0;
  const int col = cvFloor(x);
  const int row = cvFloor(y);
  const float fx = x - static_cast<float>(col);
  const float fy = y - static_cast<float>(row);
  const auto surface = [&](int u, int v) {
    const float rho = value(u, v);
    return std::abs(rho - nearest) <= 2 * kSameSurface * nearest ? rho : nearest;
  };
  return (1 - fy) * ((1 - fx) * surface(col, row) + fx * surface(col + 1, row)) +
         fy * ((1 - fx) * surface(col, row + 1) + fx * surface(col + 1, row + 1));
}

}  // namespace

HeightMap::HeightMap(const std::vector<graph::Keyframe>& keyframes,
                     const store::MapMetadata& metadata,
                     int threads)
    : raster_(GridOf(keyframes, metadata)) {
  const store::MosaicGrid& grid = Grid();
  if (grid.width_px == 0) return;
  const double finest = FinestStep(keyframes, metadata);
  SurfaceVotes votes;
  ForEachPoint(keyframes,
               metadata,
               [&](const cv::Point2d& at, const heights::HeightCell& cell, double step) {
                 const double radius = kReach * step / (cell.rho * grid.resolution);
                 const double part = kAccurate / std::clamp<double>(cell.sigma, kAccurate, kWeak);
                 // Where there are finer fields, blocks fill what those leave open.
                 const double share = finest / step;
                 const SurfaceVotes::Vote vote{
                     static_cast<float>((at.x - grid.min_x) / grid.resolution - 0.5),
                     static_cast<float>((grid.max_y - at.y) / grid.resolution - 0.5),
                     std::min(static_cast<float>(radius), SurfaceVotes::kMaxRadius),
                     cell.rho,
                     static_cast<float>(share * share * part * part)};
                 votes.Add(vote);
                 raster_.AddAround(static_cast<int>(vote.col), static_cast<int>(vote.row));
               });
  const RatioRaster elected =
      raster_.Transformed(threads, [&](const cv::Rect& window, const cv::Mat_<float>& /*ratios*/) {
        return votes.Elect(window);
      });
  raster_ = ReplaceSeenThrough(elected, keyframes, metadata, threads);
  range_ = raster_.Range();
}

std::vector<cv::Point2d> HeightMap::Settle(const std::vector<graph::Keyframe>& keyframes,
                                           const store::MapMetadata& metadata,
                                           const ImageAgreement& agreement,
                                           int threads) {
  SettledSurfaces settled = SettleSurfaces(raster_, keyframes, metadata, agreement, threads);
  raster_ = std::move(settled.raster);
  range_ = raster_.Range();
  return std::move(settled.moving);
}

float HeightMap::RatioAt(double x_map, double y_map) const {
  if (empty()) return 0;
  const store::MosaicGrid& grid = Grid();
  return Interpolate(static_cast<float>((x_map - grid.min_x) / grid.resolution - 0.5),
                     static_cast<float>((grid.max_y - y_map) / grid.resolution - 0.5),
                     [this](int col, int row) { return raster_.At(col, row); });
}

cv::Mat HeightMap::RatiosOver(const cv::Rect& window, const store::MosaicGrid& mosaic) const {
  if (empty()) return {};
  const store::MosaicGrid& grid = Grid();
  const double scale = mosaic.resolution / grid.resolution;
  const double x = (mosaic.min_x - grid.min_x) / grid.resolution + 0.5 * scale - 0.5;
  const double y = (grid.max_y - mosaic.max_y) / grid.resolution + 0.5 * scale - 0.5;
  const cv::Point first(cvFloor(x + window.x * scale) - 1, cvFloor(y + window.y * scale) - 1);
  const cv::Point last(cvCeil(x + window.br().x * scale) + 1,
                       cvCeil(y + window.br().y * scale) + 1);
  const cv::Mat raster = raster_.Ratios({first, last + cv::Point(1, 1)});
  if (cv::countNonZero(raster) == 0) return {};
  const auto value = [&](int col, int row) {
    return raster.ptr<float>(row - first.y)[col - first.x];
  };
  cv::Mat ratios(window.size(), CV_32FC1);
  for (int row = 0; row < window.height; ++row) {
    const auto v = static_cast<float>(y + (window.y + row) * scale);
    auto* values = ratios.ptr<float>(row);
    for (int col = 0; col < window.width; ++col) {
      const float rho = Interpolate(static_cast<float>(x + (window.x + col) * scale), v, value);
      values[col] = rho > 0 ? rho : 1;
    }
  }
  return ratios;
}

bool HeightMap::Sees(const ViewPlacement& view, const cv::Point2d& p_map, float rho) const {
  const store::MosaicGrid& grid = Grid();
  // At the ratio r the ray is above `foot` + rho / r * (p_map - foot), foot: below the camera.
  const float nearest = range_[1];
  if (empty() || rho * (1 + kNearer) >= nearest) return true;
  const cv::Point2d foot = view.Foot();
  const cv::Point2d way = p_map - foot;
  const double last = rho / nearest;  // part of the way
  const double cells = cv::norm(way) * (1 - last) / grid.resolution;
  const int steps = cvCeil(cells);
  for (int i = 1; i <= steps; ++i) {
    const double part = 1 - (1 - last) * i / steps;
    const cv::Point2d at = foot + part * way;
    const float surface = raster_.At(cvFloor((at.x - grid.min_x) / grid.resolution),
                                     cvFloor((grid.max_y - at.y) / grid.resolution));
    if (surface * part > rho * (1 + kNearer)) return false;
  }
  return true;
}

}  // namespace ceilmap::mosaic
