#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/remap_table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::calib {

/// A pinhole camera without distortion and with square pixels at the position of a mounted camera,
/// with a freely chosen viewing direction. It produces the image of a perfectly aligned mount. The
/// axis of the mounted camera keeps its pixel, so that the image keeps its content. Internal:
/// CeilingView and ForwardView use it.
class VirtualCamera {
 public:
  /// @param R_base_view its optical axes in base; its z axis within 90 degrees of that of the
  ///   camera.
  VirtualCamera(const MountedCamera& mounted, const Eigen::Matrix3d& R_base_view);

  [[nodiscard]] double FocalLength() const { return focal_px_; }
  /// From the centre of the top-left pixel; may lie outside the image.
  [[nodiscard]] const Eigen::Vector2d& PrincipalPoint() const { return principal_px_; }

  /// Position in the raw image of a pixel of the virtual image.
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

/// Warps a raw image by a table. Returns the image itself, without a copy, when the table is empty.
/// @throws InputError when it is not CV_8UC1 of this size.
const cv::Mat& RectifyBy(const RemapTable& table,
                         cv::Size size,
                         const cv::Mat& raw,
                         cv::Mat& buffer);

}  // namespace ceilmap::calib
