#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/remap_table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::calib {

/// A pinhole camera without distortion and with square pixels that stands where a mounted camera
/// stands, but looks exactly along a direction of its own choice: what an image would be if the
/// mount were perfect. The mounted camera's axis keeps its pixel, so that the image keeps its
/// content. Internal: CeilingView and ForwardView are made of it.
class VirtualCamera {
 public:
  /// @param R_base_view  its optical axes in base; its z within 90 degrees of the camera's.
  VirtualCamera(const MountedCamera& mounted, const Eigen::Matrix3d& R_base_view);

  [[nodiscard]] double FocalLength() const { return focal_px_; }
  /// From the top-left pixel's centre; may lie outside the image.
  [[nodiscard]] const Eigen::Vector2d& PrincipalPoint() const { return principal_px_; }

  /// Where a pixel of the virtual image lies in the raw one.
  [[nodiscard]] std::optional<cv::Point2d> Raw(double u, double v) const;
  /// The table that draws the virtual image; empty when it would move no pixel by 0.001 px.
  [[nodiscard]] RemapTable MakeTable() const;

 private:
  [[nodiscard]] bool MovesPixels() const;

  PinholeCamera camera_;
  double focal_px_;
  Eigen::Vector2d principal_px_;
  Eigen::Matrix3d R_cam_view_;
};

/// Draws a raw image by a table; the image itself, without a copy, when the table is empty.
/// @throws InputError when it is not CV_8UC1 of this size.
const cv::Mat& RectifyBy(const RemapTable& table,
                         cv::Size size,
                         const cv::Mat& raw,
                         cv::Mat& buffer);

}  // namespace ceilmap::calib
