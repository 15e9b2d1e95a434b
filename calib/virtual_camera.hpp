#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/remap_table.hpp"
#include "calib/rig.hpp"
#include "calib/view_frame.hpp"

namespace ceilmap::calib {

/// A pinhole camera without distortion and with square pixels at the position of a mounted camera,
/// with a freely chosen viewing direction and image. It produces the image of a perfectly aligned
/// mount. Internal: CeilingView and ForwardView use it.
class VirtualCamera {
 public:
  /// @param R_base_view its optical axes in base.
  VirtualCamera(const MountedCamera& mounted,
                const Eigen::Matrix3d& R_base_view,
                const ViewFrame& frame);

  /// The table that draws the virtual image; empty when it would move no pixel by 0.001 px.
  [[nodiscard]] RemapTable MakeTable() const;
  /// Position of a pixel of the virtual image in the raw image, which may lie outside it; nothing
  /// where the lens shows none.
  [[nodiscard]] std::optional<cv::Point2d> Raw(double u, double v) const;
  [[nodiscard]] cv::Size Size() const { return frame_.size; }
  [[nodiscard]] cv::Size RawSize() const { return lens_.Size(); }

 private:
  [[nodiscard]] bool MovesPixels() const;

  Lens lens_;
  ViewFrame frame_;
  Eigen::Matrix3d R_cam_view_;
};

/// @throws InputError when a raw image is not CV_8UC1 of this size.
void CheckRaw(const cv::Mat& raw, cv::Size size);

/// Warps a raw image by a table. Returns the image itself, without a copy, when the table is empty.
/// @param size  of raw images. @throws InputError when it is not CV_8UC1 of this size.
const cv::Mat& RectifyBy(const RemapTable& table,
                         cv::Size size,
                         const cv::Mat& raw,
                         cv::Mat& buffer);

}  // namespace ceilmap::calib
