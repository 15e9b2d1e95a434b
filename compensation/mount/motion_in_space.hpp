#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calib/base/twist2.hpp"
#include "calib/base/velocity_predictor.hpp"
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
  /// @param known  Velocities of base at some of the images, by rising stamps, for a rolling
  /// shutter: a robot that starts within two images is lost without them. Empty: none is known.
  explicit MotionInSpace(const calib::CeilingView& view, std::vector<StampedTwist2> known = {});

  /// Adds the next frame: p_first = T_first_base * p_base. The first frame is level by definition.
  /// Images of a rolling shutter are drawn with the velocity that they show; where this differs
  /// from the predicted one, they are drawn and measured again. The first image is drawn again when
  /// the second one shows how fast the robot was.
  /// @param raw  CV_8UC1, as the camera took it. Stamps must increase.
  /// @return nothing when the motion cannot be measured.
  std::optional<Eigen::Isometry3d> Add(const cv::Mat& raw, double stamp_s);

 private:
  struct Drawn {
    compensation::CeilingTracker::Frame frame;
    compensation::CeilingMotion motion;
  };
  struct Placed {
    Eigen::Isometry3d T_first_base;
    double stamp_s = 0;
  };
  [[nodiscard]] Twist2 Expected(double stamp_s) const;
  [[nodiscard]] Pose2 Apparent(const Eigen::Isometry3d& T_first_base) const;
  void Begin(const cv::Mat& raw, double stamp_s, const Twist2& velocity);
  std::optional<Drawn> Measure(const cv::Mat& raw, double stamp_s, const Twist2& velocity);
  std::optional<Drawn> MeasureRolling(const cv::Mat& raw, double stamp_s);
  void Renew(compensation::CeilingTracker::Frame& frame, const compensation::CeilingMotion& motion);

  const calib::CeilingView& view_;
  compensation::CeilingTracker tracker_;
  calib::LevelView level_view_;
  Eigen::Isometry3d T_first_reference_ = Eigen::Isometry3d::Identity();
  cv::Mat buffer_;
  // Of a rolling shutter only:
  std::vector<StampedTwist2> known_;
  cv::Mat first_raw_;  // until its velocity is known
  std::optional<Placed> last_;
  VelocityPredictor velocity_;
};

}  // namespace ceilmap::mount
