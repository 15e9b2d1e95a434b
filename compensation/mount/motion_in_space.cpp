#include "compensation/mount/motion_in_space.hpp"

#include "calib/base/tilt.hpp"

namespace ceilmap::mount {

using Eigen::Isometry3d;

MotionInSpace::MotionInSpace(const calib::CeilingView& view) : tracker_(view), level_view_(view) {}

std::optional<Isometry3d> MotionInSpace::Add(const cv::Mat& image, double stamp_s) {
  compensation::CeilingTracker::Frame frame = tracker_.Analyze(image, stamp_s);
  if (!tracker_.HasReference()) {
    tracker_.SetReference(frame);
    return T_first_reference_;
  }
  const std::optional<compensation::CeilingMotion> motion = tracker_.Measure(frame);
  if (!motion) return std::nullopt;
  const Isometry3d T_first_base = T_first_reference_ * motion->T_reference_base;
  Renew(frame, *motion);
  return T_first_base;
}

// Prefers a level frame to one that must be drawn level; takes any frame before the ceiling is
// lost.
void MotionInSpace::Renew(compensation::CeilingTracker::Frame& frame,
                          const compensation::CeilingMotion& motion) {
  constexpr double kRenewOverlap = 0.75;
  constexpr double kMinOverlap = 0.55;
  constexpr double kLevelSigmas = 2;
  if (motion.overlap > kRenewOverlap) return;
  const PlanarTilt at = FromSpace(motion.T_reference_base);
  const TiltAngles tilt{{at.tilt.pitch_rad, at.tilt.roll_rad}, motion.covariance};
  if (tilt.Sigmas() < kLevelSigmas) {
    tracker_.SetReference(frame);
  } else if (motion.overlap < kMinOverlap) {
    cv::Mat level;
    Tilt turn = at.tilt;
    turn.lift_m = 0;  // it is part of the reference's own pose
    level_view_.Draw(frame.image.pixels, turn, level);
    tracker_.SetReference(frame, level);
  } else {
    return;
  }
  Tilt lift;
  lift.lift_m = at.tilt.lift_m;
  T_first_reference_ = T_first_reference_ * ToSpace(at.pose, lift);
}

}  // namespace ceilmap::mount
