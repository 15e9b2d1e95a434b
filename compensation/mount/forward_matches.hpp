#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "calib/rig.hpp"
#include "calib/solve/forward_mount.hpp"

namespace ceilmap::mount {

/// Tracks corners in the images of a forward camera while the robot moves, and returns matches
/// between pairs of images together with the robot's motion between them.
///
/// Corners are tracked from image to image (cv::calcOpticalFlowPyrLK with a check backwards), from
/// where the robot's motion and the known mount predict them. The matches of a pair are then
/// measured between its two images alone, with an affine deformation of each corner's surroundings
/// (cv::findTransformECC): a window that only translates drifts as objects come nearer.
class ForwardFeatureTracker {
 public:
  /// @param forward  as far as it is known: errors of 10 degrees are permitted.
  explicit ForwardFeatureTracker(const calib::MountedCamera& forward);

  /// Adds the next image.
  /// @param image  CV_8UC1, as the camera took it; empty: none at this time.
  /// @param T_first_base  pose of the robot in space, p_first = T_first_base * p_base
  ///   (MotionInSpace); nothing: unknown. Without image or pose, all tracks end.
  void Add(const cv::Mat& image, const std::optional<Eigen::Isometry3d>& T_first_base);

  /// All pairs so far, in order of time: at least 8 cm or 2.5 degrees apart, with at least 30
  /// matches each. To be called once.
  std::vector<calibration::MotionWithMatches> Take() { return std::move(motions_); }

 private:
  void Begin(const cv::Mat& image, const Eigen::Isometry3d& T_first_base);
  void Track(const cv::Mat& image, const Eigen::Isometry3d& T_first_base);
  [[nodiscard]] std::vector<cv::Point2f> Predict(const Eigen::Isometry3d& T_last_current) const;
  void AddPair(const cv::Mat& image, const Eigen::Isometry3d& T_first_base);
  [[nodiscard]] std::vector<Eigen::Vector2d> Rays(const std::vector<cv::Point2f>& pixels) const;

  calib::MountedCamera forward_;
  cv::Mat last_;
  cv::Mat anchor_;  // where corners were chosen
  Eigen::Isometry3d T_first_last_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_first_anchor_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_first_pair_ = Eigen::Isometry3d::Identity();  // second image of the last pair
  std::vector<cv::Point2f> at_anchor_;
  std::vector<cv::Point2f> at_last_;
  std::size_t chosen_ = 0;
  std::vector<calibration::MotionWithMatches> motions_;
};

}  // namespace ceilmap::mount
