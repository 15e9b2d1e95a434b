#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "calib/rig.hpp"
#include "calib/solve/forward_mount.hpp"

namespace ceilmap::recordings {

/// Follows what a forward camera shows while the robot moves, and tells pairs of moments with what
/// both of them show. Corners are followed from image to image (cv::calcOpticalFlowPyrLK), from
/// where the robot's motion and the camera as it is known put them; each must be found again
/// backwards. What a pair tells is found between its two images alone, the surroundings of each
/// corner being stretched as they appear (cv::findTransformECC, affine): a window that only moves
/// drifts as things come nearer.
class ForwardFeatureTracker {
 public:
  /// @param forward  as far as it is known: 10 degrees off do no harm.
  explicit ForwardFeatureTracker(const calib::MountedCamera& forward);

  /// The next image. @param image  CV_8UC1, as the camera took it. @param T_first_base  where
  /// the robot was; nothing: not known, what was followed is given up.
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
  cv::Mat anchor_;  // the one where corners were chosen
  Eigen::Isometry3d T_first_before_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_first_anchor_ = Eigen::Isometry3d::Identity();    // where corners were chosen
  Eigen::Isometry3d T_first_reported_ = Eigen::Isometry3d::Identity();  // of the last pair
  std::vector<cv::Point2f> at_anchor_;
  std::vector<cv::Point2f> now_;
  std::size_t chosen_ = 0;
  std::vector<calibration::MotionWithMatches> motions_;
};

}  // namespace ceilmap::recordings
