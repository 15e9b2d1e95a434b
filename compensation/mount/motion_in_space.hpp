#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/ceiling_view.hpp"
#include "calib/level_view.hpp"
#include "compensation/ceiling_tracker.hpp"

namespace ceilmap::mount {

/// Motion of a robot in space, tilt and lift included, from the ceiling alone. The path is chained
/// from one reference image to the next, each measured by CeilingTracker. It is meant for short
/// recordings, e.g. of a calibration: over longer paths the errors of the references accumulate.
class MotionInSpace {
 public:
  /// @param view  View of a rig; must outlive this object.
  explicit MotionInSpace(const calib::CeilingView& view);

  /// Adds the next frame: p_first = T_first_base * p_base. The first frame is level by definition.
  /// @param image  CV_8UC1, rectified. Stamps must increase.
  /// @return nothing when the motion cannot be measured.
  std::optional<Eigen::Isometry3d> Add(const cv::Mat& image, double stamp_s);

 private:
  void Renew(compensation::CeilingTracker::Frame& frame, const compensation::CeilingMotion& motion);

  compensation::CeilingTracker tracker_;
  calib::LevelView level_view_;
  Eigen::Isometry3d T_first_reference_ = Eigen::Isometry3d::Identity();
};

}  // namespace ceilmap::mount
