#include "localization/depth_drawing.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace ceilmap::localization {
namespace {

constexpr int kStepPx = 2;

/// A window of the raster of heights, read once.
struct Raster {
  cv::Mat ratios;
  double min_x;
  double max_y;
  double resolution;

  /// 0: not known.
  [[nodiscard]] float At(const cv::Point2d& p) const {
    const auto column = static_cast<int>(std::floor((p.x - min_x) / resolution));
    const auto row = static_cast<int>(std::floor((max_y - p.y) / resolution));
    if (column < 0 || row < 0 || column >= ratios.cols || row >= ratios.rows) return 0;
    return ratios.at<float>(row, column);
  }
};

Raster Read(const mosaic::HeightMap& heights, const cv::Rect2d& bounds) {
  const store::MosaicGrid& grid = heights.Grid();
  const auto column = [&](double x) {
    return static_cast<int>(std::floor((x - grid.min_x) / grid.resolution));
  };
  const auto row = [&](double y) {
    return static_cast<int>(std::floor((grid.max_y - y) / grid.resolution));
  };
  const cv::Rect window(cv::Point(column(bounds.x), row(bounds.br().y)),
                        cv::Point(column(bounds.br().x) + 1, row(bounds.y) + 1));
  return {heights.Ratios(window),
          grid.min_x + window.x * grid.resolution,
          grid.max_y - window.y * grid.resolution,
          grid.resolution};
}

}  // namespace

DepthDrawing::DepthDrawing(const mosaic::HeightMap& heights,
                           const store::MapMetadata& metadata,
                           const calib::CeilingView& view)
    : heights_(heights),
      view_(view),
      map_distance_(metadata.view_focal_px * metadata.view_units_per_px),
      view_distance_(view.FocalLength() * view.MetresPerPixel()) {}

double DepthDrawing::ToView(double map_rho) const {
  const double height = map_distance_ / map_rho - (map_distance_ - view_distance_);
  constexpr double kNearest = 0.1;  // of the plane's distance; nearer things are not drawn
  return view_distance_ / std::max(height, kNearest * view_distance_);
}

double DepthDrawing::ToMap(double view_rho) const {
  return map_distance_ / (view_distance_ / view_rho + map_distance_ - view_distance_);
}

SeenSurface DepthDrawing::SurfaceOf(const mosaic::ViewPlacement& placement,
                                    const cv::Mat& ratios) const {
  SeenSurface seen{
      cv::Mat(ratios.size(), CV_32FC2), cv::Mat(ratios.size(), CV_32FC1), placement.Foot()};
  for (int v = 0; v < ratios.rows; ++v) {
    for (int u = 0; u < ratios.cols; ++u) {
      const float rho = ratios.at<float>(v, u);
      const cv::Point2d place = placement.ToMap(u, v, rho) - seen.origin;
      seen.places.at<cv::Vec2f>(v, u) = {static_cast<float>(place.x), static_cast<float>(place.y)};
      seen.ratios.at<float>(v, u) = static_cast<float>(ToMap(rho));
    }
  }
  return seen;
}

cv::Mat DepthDrawing::Ratios(const mosaic::ViewPlacement& placement) const {
  const cv::Size size = view_.Size();
  const Raster raster = Read(heights_, placement.Bounds(1));
  const double nearest = ToView(std::max(1.0F, heights_.Range()[1]));
  const double farthest = std::min(1.0, ToView(heights_.Range()[0]));
  // The map's ratio of the surface at a place, for the other camera.
  const auto surface = [&](const cv::Point2d& p) {
    const float rho = raster.At(p);
    return rho > 0 ? ToView(rho) : 1.0;
  };
  cv::Mat coarse(
      (size.height + kStepPx - 1) / kStepPx, (size.width + kStepPx - 1) / kStepPx, CV_32FC1);
  const double pixel = raster.resolution / view_.MetresPerPixel();  // of the raster, in the view
  for (int row = 0; row < coarse.rows; ++row) {
    for (int col = 0; col < coarse.cols; ++col) {
      const double u = col * kStepPx + 0.5 * (kStepPx - 1);
      const double v = row * kStepPx + 0.5 * (kStepPx - 1);
      const double off = std::hypot(u - placement.Principal().x, v - placement.Principal().y);
      // Along the ray from the nearest surface to the farthest, by a pixel of the raster.
      const double first = 1 / nearest;
      const double last = 1 / farthest;
      const int steps = 1 + static_cast<int>((last - first) * off / pixel);
      constexpr double kOnSurface = 0.02;
      double found = surface(placement.ToMap(u, v, 1));
      for (int i = 0; i <= steps; ++i) {
        const double rho = 1 / (first + (last - first) * i / steps);
        const double there = surface(placement.ToMap(u, v, rho));
        if (there < (1 - kOnSurface) * rho) continue;
        found = there;
        break;
      }
      coarse.at<float>(row, col) = static_cast<float>(found);
    }
  }
  cv::Mat ratios;
  cv::resize(
      coarse, ratios, {coarse.cols * kStepPx, coarse.rows * kStepPx}, 0, 0, cv::INTER_NEAREST);
  return ratios(cv::Rect({0, 0}, size)).clone();
}

heights::HeightField DepthDrawing::Field(const cv::Mat& ratios, heights::HeightField grid) {
  constexpr int kHalf = 10;  // pixels of a cell to each side
  constexpr float kSigma = 0.012F;
  const cv::Rect whole({0, 0}, ratios.size());
  std::vector<float> values;
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    const Eigen::Vector2d at =
        grid.Centre(i) + Eigen::Vector2d(0.5 * (ratios.cols - 1), 0.5 * (ratios.rows - 1));
    const cv::Rect cell = cv::Rect(static_cast<int>(at.x()) - kHalf,
                                   static_cast<int>(at.y()) - kHalf,
                                   2 * kHalf,
                                   2 * kHalf) &
                          whole;
    if (cell.empty()) continue;
    values.clear();
    for (int v = cell.y; v < cell.br().y; v += kStepPx) {
      for (int u = cell.x; u < cell.br().x; u += kStepPx) values.push_back(ratios.at<float>(v, u));
    }
    std::sort(values.begin(), values.end());
    // What the nearer surface of a cell shows outweighs the other, and it may be the other one.
    const auto part = [&](double share) {
      return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    };
    grid.cells[i] = {
        part(0.5),
        std::min(heights::kUnknown.sigma, std::hypot(kSigma, 0.5F * (part(0.9) - part(0.1))))};
  }
  constexpr double kScaleSigma = 0.003;
  grid.scale_sigma = kScaleSigma;
  return grid;
}

}  // namespace ceilmap::localization
