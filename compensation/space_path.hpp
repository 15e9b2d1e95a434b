#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/ceiling_view.hpp"
#include "calib/level_view.hpp"
#include "compensation/ceiling_tracker.hpp"

namespace ceilmap::compensation {

/// Where a robot went in space, tilt and lift included, by the ceiling alone: from one reference
/// image to the next, each as CeilingTracker measures it. For short recordings, as of a
/// calibration; what lies further apart adds up the errors of the references between.
class SpacePath {
 public:
  /// @param view  of a rig; must outlive the path.
  explicit SpacePath(const calib::CeilingView& view);

  /// The next frame: p_first = T_first_base * p_base, the first frame being level by definition.
  /// @param image  CV_8UC1, rectified. Stamps must increase.
  /// @return nothing where the ceiling does not tell.
  std::optional<Eigen::Isometry3d> Follow(const cv::Mat& image, double stamp_s);

 private:
  void Renew(CeilingTracker::Frame& frame, const CeilingMotion& motion);

  CeilingTracker tracker_;
  calib::LevelView level_view_;
  Eigen::Isometry3d T_first_reference_ = Eigen::Isometry3d::Identity();
};

}  // namespace ceilmap::compensation
