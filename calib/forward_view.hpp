#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "calib/remap_table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::calib {

/// The model of the forward camera that all other libraries use: a virtual pinhole camera whose
/// optical axis is horizontal when the robot is level, without distortion and with square pixels. A
/// camera that is mounted with its axis raised keeps its image section; its horizon then lies below
/// the centre of the image, or even below the image.
class ForwardView {
 public:
  /// @param forward  its optical axis within 45 deg of base's x axis.
  /// @throws InputError otherwise, and for an invalid camera.
  explicit ForwardView(const MountedCamera& forward);

  [[nodiscard]] cv::Size Size() const { return size_; }
  /// Pixels, > 0.
  [[nodiscard]] double FocalLength() const { return focal_px_; }
  /// The pixel on the horizon in the viewing direction, relative to the centre of the image.
  [[nodiscard]] const Eigen::Vector2d& Horizon() const { return horizon_px_; }
  /// Viewing direction: counter-clockwise from the x axis of base, rad.
  [[nodiscard]] double Yaw() const { return yaw_rad_; }
  /// CV_8UC1, 255 where the rectified image has content; empty when all pixels have content.
  [[nodiscard]] const cv::Mat& Mask() const { return mask_; }

  /// As CeilingView::Rectify.
  const cv::Mat& Rectify(const cv::Mat& raw, cv::Mat& buffer) const;

 private:
  cv::Size size_;
  double focal_px_ = 0;
  double yaw_rad_ = 0;
  Eigen::Vector2d horizon_px_;
  RemapTable table_;
  cv::Mat mask_;
};

}  // namespace ceilmap::calib
