#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calib/base/pose2.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// Mapping between pixels of a keyframe's image and the ceiling, in both directions. On the
/// reference plane
///   p_map = T_map_view * (units_per_px * (pixel - centre)),   centre = ((W-1)/2, (H-1)/2).
/// A point of inverse height ratio rho (mapping/heights/height_field.hpp) is seen rho times as far
/// from the principal point as the point of the plane above it:
///   p_map = T_map_view * (units_per_px * ((pixel - principal) / rho + principal - centre)).
class ViewPlacement {
 public:
  /// @param principal_px  principal point, from the centre of the image.
  ViewPlacement(const Pose2& T_map_view,
                cv::Size size,
                double units_per_px,
                const cv::Point2d& principal_px = {});

  /// Pixel (u, v), not necessarily inside the image.
  [[nodiscard]] cv::Point2d ToPixel(double x_map, double y_map) const {
    const double dx = x_map - x_;
    const double dy = y_map - y_;
    return {u_per_x_ * dx + u_per_y_ * dy + centre_.x, -u_per_y_ * dx + u_per_x_ * dy + centre_.y};
  }
  /// The pixel that shows the point of ratio rho > 0.
  [[nodiscard]] cv::Point2d ToPixel(double x_map, double y_map, double rho) const {
    return principal_ + rho * (ToPixel(x_map, y_map) - principal_);
  }
  [[nodiscard]] cv::Point2d ToMap(double u, double v) const;
  [[nodiscard]] cv::Point2d ToMap(double u, double v, double rho) const;

  /// Centre of the image in the map.
  [[nodiscard]] cv::Point2d Centre() const { return {x_, y_}; }
  /// The place below the camera, which it sees straight above, whatever the height.
  [[nodiscard]] cv::Point2d Foot() const { return ToMap(principal_.x, principal_.y); }
  [[nodiscard]] const cv::Point2d& Principal() const { return principal_; }  ///< pixel
  /// Axis-aligned box in the map around the image, up to the pixels' outer edges, of what it
  /// shows of ratio rho.
  [[nodiscard]] cv::Rect2d Bounds(double rho = 1) const;

 private:
  double x_;
  double y_;
  double u_per_x_;  // cos(yaw) / units_per_px
  double u_per_y_;  // sin(yaw) / units_per_px
  cv::Point2d centre_;
  cv::Point2d principal_;
  cv::Size size_;
};

/// The placements of all keyframes, in their order.
std::vector<ViewPlacement> PlaceViews(const std::vector<graph::Keyframe>& keyframes,
                                      const store::MapMetadata& metadata);

}  // namespace ceilmap::mosaic
