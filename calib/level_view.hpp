#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>

#include "calib/base/tilt.hpp"
#include "calib/ceiling_view.hpp"

namespace ceilmap::calib {

/// Removes a known tilt from images of the ceiling. The result is the image of a level robot with
/// the foot of the mast at the same place. It is exact for points in the ceiling plane.
class LevelView {
 public:
  /// @param view of a rig (focal length and camera height known). Only its parameters and mask are
  ///   kept. @throws InputError for a view in pixels or of rectified images.
  explicit LevelView(const CeilingView& view);

  /// Homography: pixel of the level image -> pixel of the tilted one, both from the top-left
  /// pixel's centre; (u, v, 1) up to scale.
  [[nodiscard]] Eigen::Matrix3d TiltedFromLevel(const Tilt& tilt) const;

  /// Displacement, in the axes of base (x forward, y left) and metres, of the point where the axis
  /// of the upward camera meets the ceiling, relative to a level robot. This is the error of the
  /// similarity model. With the camera over the mast's foot this is Eq. (2) and (3) of Matsumoto et
  /// al. 2010.
  [[nodiscard]] Eigen::Vector2d CeilingShift(const Tilt& tilt) const;

  /// The pose that the similarity model estimates, which assumes that every frame is level.
  [[nodiscard]] Pose2 Uncompensated(const Pose2& T_map_base, const Tilt& tilt) const;

  /// Draws the level image. @param image  CV_8UC1, rectified (CeilingView::Rectify).
  /// @param level CV_8UC1 of the same size, 0 exactly where the tilted camera has no content
  ///   (ContentMask); must not share memory with `image`. Its buffer is reused. About 2 ms for 640
  ///   x 480 pixels. Thread-safe.
  void Draw(const cv::Mat& image, const Tilt& tilt, cv::Mat& level) const;

 private:
  [[nodiscard]] std::uint8_t Sample(const cv::Mat& image, float x, float y) const;
  [[nodiscard]] Eigen::Isometry3d T_level_camera(const Tilt& tilt) const;

  cv::Size size_;
  cv::Mat content_;  // 255 where a sample with this top left corner has content; empty: all have
                     // content
  double focal_px_;
  double distance_m_;                // of the level camera from the ceiling
  Eigen::Vector2d principal_px_;     // from the top-left pixel's centre
  Eigen::Isometry3d T_base_camera_;  // of the virtual upward camera
};

/// Mask of the content of a levelled image: CV_8UC1, 0 where there is none; empty when all pixels
/// have content. Isolated black pixels, which occur in any dark image, count as content.
cv::Mat ContentMask(const cv::Mat& level);

}  // namespace ceilmap::calib
