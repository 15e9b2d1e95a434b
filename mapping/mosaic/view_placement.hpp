#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calib/base/pose2.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// Mapping between pixels of a keyframe's image and the ceiling, in both directions:
///   p_map = T_map_view * (units_per_px * (pixel - centre)),   centre = ((W-1)/2, (H-1)/2).
class ViewPlacement {
 public:
  ViewPlacement(const Pose2& T_map_view, cv::Size size, double units_per_px);

  /// Pixel (u, v), not necessarily inside the image.
  [[nodiscard]] cv::Point2d ToPixel(double x_map, double y_map) const {
    const double dx = x_map - x_;
    const double dy = y_map - y_;
    return {u_per_x_ * dx + u_per_y_ * dy + centre_.x, -u_per_y_ * dx + u_per_x_ * dy + centre_.y};
  }
  [[nodiscard]] cv::Point2d ToMap(double u, double v) const;

  /// Centre of the image in the map.
  [[nodiscard]] cv::Point2d Centre() const { return {x_, y_}; }
  /// Axis-aligned box in the map around the image, up to the pixels' outer edges.
  [[nodiscard]] cv::Rect2d Bounds() const;

 private:
  double x_;
  double y_;
  double u_per_x_;  // cos(yaw) / units_per_px
  double u_per_y_;  // sin(yaw) / units_per_px
  cv::Point2d centre_;
  cv::Size size_;
};

/// The placements of all keyframes, in their order.
std::vector<ViewPlacement> PlaceViews(const std::vector<graph::Keyframe>& keyframes,
                                      const store::MapMetadata& metadata);

}  // namespace ceilmap::mosaic
