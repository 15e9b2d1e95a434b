#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/pose2.hpp"
#include "calib/base/twist2.hpp"
#include "calib/remap_table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::calib {

class RollingShutter;

/// The model of the upward camera that all other libraries use: a virtual pinhole camera that
/// points exactly upwards, without distortion and with square pixels, rotated about z like the
/// mounted camera. One precomputed map removes distortion, unequal focal lengths and mounting tilts
/// from the image. When the map would move no pixel by 0.001 px or more, none is used, and the
/// images are passed through unchanged.
///
/// A level plane ceiling is then imaged to scale, and coordinates in the view's plane are
///   p_view = m_per_px * ((u, v) - c),   c = ((W-1)/2, (H-1)/2)   (u right, v down)
///   p_base = T_base_view * p_view.
/// Because v points down and the view direction points up, T_base_view is a proper planar motion
/// without reflection. The offset of the principal point from the image's centre is part of
/// T_base_view.
class CeilingView {
 public:
  /// @param up  the mounted upward camera; its optical axis within 45 deg of straight up.
  /// @param ceiling_height_m  above the floor; must be above the camera.
  /// @throws InputError when the ceiling at that height is not in the camera's view.
  CeilingView(const MountedCamera& up, double ceiling_height_m);

  /// View without a rig: one pixel is one unit of length, x forward = up in the image, y left =
  /// RIGHT in the image (seen from below, the image's right is the robot's left), centre of the
  /// image over base.
  static CeilingView InPixels(cv::Size size);

  /// View of images that are already rectified, e.g. those kept in a map.
  /// @param m_per_px > 0. @param mask see Mask(). @throws InputError when an argument is out of
  /// range.
  static CeilingView OfRectified(cv::Size size,
                                 double m_per_px,
                                 const Pose2& T_base_view,
                                 const cv::Mat& mask = {});

  /// Size of the raw images that Rectify takes.
  [[nodiscard]] cv::Size RawSize() const { return raw_size_; }
  /// Size of the view, in which Rectify returns images. It differs from RawSize for wide lenses,
  /// and where the rig gives another one (calib/README.md, "The ceiling view").
  [[nodiscard]] cv::Size Size() const { return size_; }
  /// Metres on the ceiling per pixel (1 without a rig), > 0.
  [[nodiscard]] double MetresPerPixel() const { return m_per_px_; }
  [[nodiscard]] const Pose2& T_base_view() const { return T_base_view_; }
  /// Focal length of the virtual camera in pixels; 0 when it is not known.
  [[nodiscard]] double FocalLength() const { return focal_px_; }
  /// Principal point of the virtual camera, from the top-left pixel's centre, pixels. The centre of
  /// the image when the camera is not known.
  [[nodiscard]] const Eigen::Vector2d& PrincipalPoint() const { return principal_px_; }
  /// The virtual camera's optical frame in base (identity when it is not known): its optical axis
  /// is parallel to base z, and it is rotated about z like the mounted camera.
  [[nodiscard]] const Eigen::Isometry3d& T_base_camera() const { return T_base_camera_; }
  /// True when the rows of an image are exposed at different times
  /// (MountedCamera::readout_time_s).
  [[nodiscard]] bool HasRollingShutter() const { return readout_time_s_ != 0; }
  /// Upper limit of the motion of the content between the middle row and the first or last one, px.
  [[nodiscard]] double ReadoutMotion(const Twist2& velocity) const;
  /// True when Rectify changes the image.
  [[nodiscard]] bool NeedsRectification() const { return !table_.empty(); }

  /// Rectifies a raw image into the view. Returns `raw` itself (no copy) when no rectification is
  /// needed, else fills and returns `buffer`. Pixels without a source in the raw image become 0 and
  /// are 0 in Mask().
  /// @param raw  CV_8UC1 of RawSize(). @throws InputError on another type or size. Thread-safe with
  /// a
  ///   buffer per thread.
  /// @param velocity  Of base at the time of the image, for a rolling shutter; else without effect.
  ///   The image is drawn as at the time of its middle row, for a level robot and a plane ceiling.
  ///   Pixels at the border whose content had left the image repeat that of the border. Takes three
  ///   times as long as for a robot at rest.
  const cv::Mat& Rectify(const cv::Mat& raw, cv::Mat& buffer, const Twist2& velocity = {}) const;
  /// Where Rectify finds the content of a pixel of the view, in pixels of the raw image; it may lie
  /// outside that. @return nothing where the lens shows none, and without a mounted camera.
  [[nodiscard]] std::optional<Eigen::Vector2d> RawPixel(const Eigen::Vector2d& pixel,
                                                        const Twist2& velocity = {}) const;
  /// CV_8UC1 of Size(), 255 where the rectified image has content; empty when all pixels have
  /// content.
  [[nodiscard]] const cv::Mat& Mask() const { return mask_; }

 private:
  CeilingView() = default;

  cv::Size raw_size_;
  cv::Size size_;
  double m_per_px_ = 1;
  double focal_px_ = 0;
  Eigen::Vector2d principal_px_ = Eigen::Vector2d::Zero();
  Eigen::Isometry3d T_base_camera_ = Eigen::Isometry3d::Identity();
  Pose2 T_base_view_;
  RemapTable table_;  // empty: no rectification is needed
  double readout_time_s_ = 0;
  std::shared_ptr<const RollingShutter> shutter_;  // null: not of a mounted camera
  cv::Mat mask_;
};

}  // namespace ceilmap::calib
