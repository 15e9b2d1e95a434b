#include "mapping/mosaic/view_placement.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::mosaic {

ViewPlacement::ViewPlacement(const Pose2& T_map_view,
                             cv::Size size,
                             double units_per_px,
                             const cv::Point2d& principal_px)
    : x_(T_map_view.x),
      y_(T_map_view.y),
      u_per_x_(std::cos(T_map_view.yaw) / units_per_px),
      u_per_y_(std::sin(T_map_view.yaw) / units_per_px),
      centre_((size.width - 1) / 2.0, (size.height - 1) / 2.0),
      principal_(centre_ + principal_px),
      size_(size) {}

cv::Point2d ViewPlacement::ToMap(double u, double v) const {
  // The rows of the matrix are orthogonal and of equal length, so its inverse is its transpose over
  // the squared length.
  const double squared = u_per_x_ * u_per_x_ + u_per_y_ * u_per_y_;
  const double du = u - centre_.x;
  const double dv = v - centre_.y;
  return {x_ + (u_per_x_ * du - u_per_y_ * dv) / squared,
          y_ + (u_per_y_ * du + u_per_x_ * dv) / squared};
}

cv::Point2d ViewPlacement::ToMap(double u, double v, double rho) const {
  return ToMap(principal_.x + (u - principal_.x) / rho, principal_.y + (v - principal_.y) / rho);
}

cv::Rect2d ViewPlacement::Bounds(double rho) const {
  const double right = size_.width - 0.5;
  const double bottom = size_.height - 0.5;
  // On the reference plane the result does not depend on the principal point, not even by rounding.
  const auto corner_at = [&](double u, double v) {
    return rho == 1 ? ToMap(u, v) : ToMap(u, v, rho);
  };
  cv::Point2d low = corner_at(-0.5, -0.5);
  cv::Point2d high = low;
  for (const cv::Point2d& corner :
       {corner_at(right, -0.5), corner_at(-0.5, bottom), corner_at(right, bottom)}) {
    low = {std::min(low.x, corner.x), std::min(low.y, corner.y)};
    high = {std::max(high.x, corner.x), std::max(high.y, corner.y)};
  }
  return {low, high};
}

std::vector<ViewPlacement> PlaceViews(const std::vector<graph::Keyframe>& keyframes,
                                      const store::MapMetadata& metadata) {
  std::vector<ViewPlacement> views;
  views.reserve(keyframes.size());
  for (const graph::Keyframe& keyframe : keyframes) {
    views.emplace_back(keyframe.pose.T_map_base * metadata.T_base_view,
                       metadata.view_size,
                       metadata.view_units_per_px,
                       cv::Point2d(metadata.view_principal_px.x(), metadata.view_principal_px.y()));
  }
  return views;
}

}  // namespace ceilmap::mosaic
