#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>

#include "calib/base/tilt.hpp"
#include "calib/ceiling_view.hpp"

namespace ceilmap::calib {

/// Takes a known tilt out of images of the ceiling: what the upward camera would have shown had
/// the robot stood level with its mast's foot at the same place. Exact for what lies in the
/// ceiling's plane.
class LevelView {
 public:
  /// @param view  of a rig (focal length and camera height known). Only its numbers and mask are
  ///   kept. @throws InputError for a view in pixels or of rectified images.
  explicit LevelView(const CeilingView& view);

  /// Homography: pixel of the level image -> pixel of the tilted one, both from the top-left
  /// pixel's centre; (u, v, 1) up to scale.
  [[nodiscard]] Eigen::Matrix3d TiltedFromLevel(const Tilt& tilt) const;

  /// How much farther, in base's own axes (x forward, y left) and metres, the upward camera's axis
  /// meets the ceiling than it would from a level robot: by this the similarity model is wrong.
  /// With the camera over the mast's foot this is Eq. (2) and (3) of Matsumoto et al. 2010.
  [[nodiscard]] Eigen::Vector2d CeilingShift(const Tilt& tilt) const;

  /// Where the similarity model says that the robot is, which takes every frame for level.
  [[nodiscard]] Pose2 Uncompensated(const Pose2& T_map_base, const Tilt& tilt) const;

  /// Draws the level image. @param image  CV_8UC1, rectified (CeilingView::Rectify).
  /// @param level  CV_8UC1 of the same size, 0 where the tilted camera did not look and nowhere
  ///   else (ContentMask); must not share memory with `image`, its own is used again. About 2 ms
  ///   for 640 x 480 pixels. Thread-safe.
  void Draw(const cv::Mat& image, const Tilt& tilt, cv::Mat& level) const;

 private:
  [[nodiscard]] std::uint8_t Sample(const cv::Mat& image, float x, float y) const;
  [[nodiscard]] Eigen::Isometry3d T_level_camera(const Tilt& tilt) const;

  cv::Size size_;
  cv::Mat content_;  // 255 where a sample with this top left corner has content; empty: everywhere
  double focal_px_;
  double distance_m_;                // of the level camera from the ceiling
  Eigen::Vector2d principal_px_;     // from the top-left pixel's centre
  Eigen::Isometry3d T_base_camera_;  // of the virtual upward camera
};

/// Where a levelled image has content: CV_8UC1, 0 where there is none; empty when everywhere.
/// Single black pixels, which any dark image has, are content.
cv::Mat ContentMask(const cv::Mat& level);

}  // namespace ceilmap::calib
