#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

namespace ceilmap::calib {

/// Pinhole camera with the plumb_bob distortion model (Brown-Conrady; as in ROS camera_info and
/// OpenCV). Pixel (0, 0) is the centre of the top-left pixel, so the centre of a W x H image is
/// ((W-1)/2, (H-1)/2). Optical frame: x right, y down, z along the view.
struct PinholeCamera {
  int width_px = 0;
  int height_px = 0;
  double fx = 0;  ///< focal length in pixels, > 0
  double fy = 0;
  double cx = 0;  ///< principal point in pixels
  double cy = 0;
  std::array<double, 5> distortion{};  ///< k1, k2, p1, p2, k3; all zero: no distortion

  [[nodiscard]] bool IsDistorted() const;
  [[nodiscard]] cv::Size Size() const { return {width_px, height_px}; }
  [[nodiscard]] cv::Matx33d Matrix() const { return {fx, 0, cx, 0, fy, cy, 0, 0, 1}; }

  /// Pixel that shows the point p_cam of the optical frame; inside the image or not.
  /// @return nothing for a point not in front of the camera, and for one so far off the axis that
  ///   the radial polynomial r (1 + k1 r^2 + k2 r^4 + k3 r^6) has stopped growing: from there on
  ///   the model folds back into the image and means nothing.
  [[nodiscard]] std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_cam) const;
};

}  // namespace ceilmap::calib
