#include "compensation/mount/motion_in_space.hpp"

#include <algorithm>
#include <utility>

#include "calib/base/tilt.hpp"

namespace ceilmap::mount {

using Eigen::Isometry3d;

MotionInSpace::MotionInSpace(const calib::CeilingView& view, std::vector<StampedTwist2> known)
    : view_(view), tracker_(view), level_view_(view), known_(std::move(known)) {}

std::optional<Isometry3d> MotionInSpace::Add(const cv::Mat& raw, double stamp_s) {
  if (!tracker_.HasReference()) {
    Begin(raw, stamp_s, Expected(stamp_s));
    if (view_.HasRollingShutter()) first_raw_ = raw.clone();
    return T_first_reference_;
  }
  std::optional<Drawn> drawn =
      view_.HasRollingShutter() ? MeasureRolling(raw, stamp_s) : Measure(raw, stamp_s, {});
  if (!drawn) return std::nullopt;
  const Isometry3d T_first_base = T_first_reference_ * drawn->motion.T_reference_base;
  last_ = Placed{T_first_base, stamp_s};
  Renew(drawn->frame, drawn->motion);
  return T_first_base;
}

// Between the known velocities, as far as they reach; else by those measured so far.
Twist2 MotionInSpace::Expected(double stamp_s) const {
  const auto next = std::find_if(known_.begin(), known_.end(), [&](const StampedTwist2& known) {
    return known.stamp_s >= stamp_s;
  });
  if (next == known_.end()) return velocity_.At(stamp_s).value_or(Twist2{});
  if (next == known_.begin()) return next->velocity;
  const StampedTwist2& before = *std::prev(next);
  const double part = (stamp_s - before.stamp_s) / (next->stamp_s - before.stamp_s);
  const Twist2& a = before.velocity;
  const Twist2& b = next->velocity;
  return {a.linear_m_s + part * (b.linear_m_s - a.linear_m_s),
          a.yaw_rad_s + part * (b.yaw_rad_s - a.yaw_rad_s)};
}

// Pose of a level robot that would see the ceiling at the same place: the image moves with it,
// whether the robot tilts or the measured tilt is wrong.
Pose2 MotionInSpace::Apparent(const Isometry3d& T_first_base) const {
  const PlanarTilt at = FromSpace(T_first_base);
  const Eigen::Vector2d seen = at.pose * level_view_.CeilingShift(at.tilt);
  return {seen.x(), seen.y(), at.pose.yaw};
}

void MotionInSpace::Begin(const cv::Mat& raw, double stamp_s, const Twist2& velocity) {
  tracker_.SetReference(tracker_.Analyze(view_.Rectify(raw, buffer_, velocity), stamp_s));
  last_ = Placed{T_first_reference_, stamp_s};
}

std::optional<MotionInSpace::Drawn> MotionInSpace::Measure(const cv::Mat& raw,
                                                           double stamp_s,
                                                           const Twist2& velocity) {
  Drawn drawn{tracker_.Analyze(view_.Rectify(raw, buffer_, velocity), stamp_s), {}};
  const auto motion = tracker_.Measure(drawn.frame);
  if (!motion) return std::nullopt;
  drawn.motion = *motion;
  return drawn;
}

std::optional<MotionInSpace::Drawn> MotionInSpace::MeasureRolling(const cv::Mat& raw,
                                                                  double stamp_s) {
  constexpr int kMaxAgain = 2;
  constexpr double kExactPx = 0.3;
  Twist2 assumed = Expected(stamp_s);
  for (int again = 0;; ++again) {
    std::optional<Drawn> drawn = Measure(raw, stamp_s, assumed);
    if (!drawn) return std::nullopt;
    const Isometry3d T_first_base = T_first_reference_ * drawn->motion.T_reference_base;
    const Pose2 T_last_base = Apparent(last_->T_first_base).Inverse() * Apparent(T_first_base);
    const double duration_s = stamp_s - last_->stamp_s;
    const StampedTwist2 mean{stamp_s - duration_s / 2, Twist2::Mean(T_last_base, duration_s)};
    VelocityPredictor measured = velocity_;
    measured.Add(mean);
    const Twist2 now = measured.At(stamp_s).value_or(mean.velocity);
    const Twist2 off{now.linear_m_s - assumed.linear_m_s, now.yaw_rad_s - assumed.yaw_rad_s};
    if (again == kMaxAgain || view_.ReadoutMotion(off) < kExactPx) {
      velocity_ = measured;
      first_raw_.release();
      return drawn;
    }
    assumed = now;
    if (!first_raw_.empty()) Begin(first_raw_, last_->stamp_s, now);
  }
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
