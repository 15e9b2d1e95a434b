#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/remap_table.hpp"
#include "calib/virtual_camera.hpp"

namespace ceilmap::calib {

/// Motion of the content of an image: a pixel at x, from the image's centre, moves by
/// `linear_px_s + yaw_rad_s * (-x.y, x.x)` per second (u right, v down).
struct ImageFlow {
  Eigen::Vector2d linear_px_s = Eigen::Vector2d::Zero();
  double yaw_rad_s = 0;
};

/// Rows of an image that are exposed one after the other, at equal intervals. Internal: CeilingView
/// uses it.
class RollingShutter {
 public:
  /// @param readout_time_s  From the exposure of the first row of the raw image to that of the last
  ///   one; < 0: the last row is first.
  RollingShutter(const VirtualCamera& camera, double readout_time_s)
      : camera_(camera), readout_time_s_(readout_time_s) {}

  /// Where a virtual image of the moment of the middle row finds its content in the raw image,
  /// against an image of one moment. Exact for the flow of a plane; parts nearer to the camera move
  /// faster. Cost: three projections for each of the nodes.
  [[nodiscard]] SourceShift ShiftBy(const ImageFlow& flow) const;

  /// Position in the raw image of the content of a pixel of that virtual image; nothing where the
  /// lens shows none.
  [[nodiscard]] std::optional<cv::Point2d> RawAt(const Eigen::Vector2d& pixel,
                                                 const ImageFlow& flow) const;

 private:
  [[nodiscard]] cv::Vec2f ShiftAt(const Eigen::Vector2d& pixel, const ImageFlow& flow) const;

  VirtualCamera camera_;
  double readout_time_s_;
};

}  // namespace ceilmap::calib
