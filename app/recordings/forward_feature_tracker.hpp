#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "calib/rig.hpp"
#include "calib/solve/forward_mount.hpp"

namespace ceilmap::recordings {

/// Tracks corners in a forward camera's images while the robot moves, and returns pairs of images
/// with their correspondences. Corners are tracked from image to image (cv::calcOpticalFlowPyrLK),
/// starting at the positions predicted from the robot's motion and the approximate camera, and are
/// verified by backward tracking. The correspondences of a pair are measured between its two images
/// only, with an affine deformation of each corner's neighbourhood (cv::findTransformECC), because
/// a window that is only shifted drifts when objects come nearer.
class ForwardFeatureTracker {
 public:
  /// @param forward  Approximate; its direction may have an error of 10 degrees.
  explicit ForwardFeatureTracker(const calib::MountedCamera& forward);

  /// Processes the next image. @param image  CV_8UC1, as the camera took it. @param T_first_base
  /// Pose of the robot; nothing: unknown, all tracks end.
  void Follow(const cv::Mat& image, const std::optional<Eigen::Isometry3d>& T_first_base);

  /// All pairs so far.
  std::vector<calibration::MotionWithMatches> Take() { return std::move(motions_); }

 private:
  void Begin(const cv::Mat& image, const Eigen::Isometry3d& T_first_base);
  void Track(const cv::Mat& image, const Eigen::Isometry3d& T_first_base);
  [[nodiscard]] std::vector<cv::Point2f> Expect(const Eigen::Isometry3d& T_before_now) const;
  void Report(const cv::Mat& image, const Eigen::Isometry3d& T_first_base);
  [[nodiscard]] std::vector<Eigen::Vector2d> Rays(const std::vector<cv::Point2f>& pixels) const;

  calib::MountedCamera forward_;
  cv::Mat before_;  // the previous image
  cv::Mat anchor_;  // the image in which corners were selected
  Eigen::Isometry3d T_first_before_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_first_anchor_ = Eigen::Isometry3d::Identity();  // at the selection of corners
  Eigen::Isometry3d T_first_reported_ = Eigen::Isometry3d::Identity();  // at the last pair
  std::vector<cv::Point2f> at_anchor_;
  std::vector<cv::Point2f> now_;
  std::size_t chosen_ = 0;
  std::vector<calibration::MotionWithMatches> motions_;
};

}  // namespace ceilmap::recordings
