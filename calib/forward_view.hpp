#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "calib/remap_table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::calib {

/// The forward camera as the rest of the program sees it: a virtual pinhole camera that looks level
/// when the robot does, straight at the horizon, without distortion and with square pixels. A
/// camera that is mounted raised keeps its image; its horizon then lies below the image's
/// centre, or even below the image.
class ForwardView {
 public:
  /// @param forward  its optical axis within 45 deg of base's x axis.
  /// @throws InputError otherwise, and for a camera that cannot be.
  explicit ForwardView(const MountedCamera& forward);

  [[nodiscard]] cv::Size Size() const { return size_; }
  /// Pixels, > 0.
  [[nodiscard]] double FocalLength() const { return focal_px_; }
  /// The pixel that looks straight ahead and level, from the image's centre.
  [[nodiscard]] const Eigen::Vector2d& Horizon() const { return horizon_px_; }
  /// Where it looks: counter-clockwise from base's x axis, rad.
  [[nodiscard]] double Yaw() const { return yaw_rad_; }
  /// CV_8UC1, 255 where the rectified image has content; empty when everywhere.
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
