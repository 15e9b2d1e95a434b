#include "compensation/shutter_tracker.hpp"

#include <cmath>
#include <utility>

namespace ceilmap::compensation {
namespace {

/// Whether a robot that accelerates may reach one velocity from the other.
bool IsReached(const Twist2& from, const Twist2& to, double duration_s) {
  constexpr double kAcceleration = 2;     // m/s^2
  constexpr double kYawAcceleration = 5;  // rad/s^2
  return (to.linear_m_s - from.linear_m_s).norm() < kAcceleration * duration_s &&
         std::abs(to.yaw_rad_s - from.yaw_rad_s) < kYawAcceleration * duration_s;
}

/// Whether a velocity is so unlike the expected one that the image was matched at a wrong place.
bool IsElsewhere(const Twist2& expected, const Twist2& measured) {
  constexpr double kMaxJump = 2;     // m/s
  constexpr double kMaxYawJump = 4;  // rad/s
  return (measured.linear_m_s - expected.linear_m_s).norm() > kMaxJump ||
         std::abs(measured.yaw_rad_s - expected.yaw_rad_s) > kMaxYawJump;
}

}  // namespace

/// Pose of a level robot that would see the ceiling at the same place. The image moves with it,
/// whether the robot tilts or the measured tilt is wrong: it can be measured better than the pose.
Pose2 ShutterTracker::Apparent(const Eigen::Isometry3d& T_reference_base) const {
  const PlanarTilt at = FromSpace(T_reference_base);
  const Eigen::Vector2d seen = at.pose * level_view_.CeilingShift(at.tilt);
  return {seen.x(), seen.y(), at.pose.yaw};
}

StampedTwist2 ShutterTracker::MeanVelocity(const CeilingTracker::Frame& before,
                                           const CeilingTracker::Frame& now) const {
  const double duration_s = now.stamp_s - before.stamp_s;
  const Pose2 T_before_now =
      Apparent(before.T_reference_base).Inverse() * Apparent(now.T_reference_base);
  return {now.stamp_s - duration_s / 2, Twist2::Mean(T_before_now, duration_s)};
}

/// The velocity at a frame, as measured here until the frame before, else as the pose of the robot
/// shows it; nothing where it is not known.
std::optional<Twist2> ShutterTracker::Expected(const TiltFrame& frame, bool followed) const {
  const bool known = frame.velocity.linear_m_s.norm() > 0 || frame.velocity.yaw_rad_s != 0;
  std::optional<Twist2> expected = velocity_.At(frame.stamp_s);
  if (known && !(followed && expected)) expected = frame.velocity;
  return expected;
}

/// Two images that were rectified with the same wrong velocity are distorted alike, and show the
/// right one. The keyframe is then rectified with it, or all later images would seem tilted.
/// @return  whether the images must be compared again.
bool ShutterTracker::CorrectGuess(const Twist2& now, double stamp_s) {
  if (!guess_ || velocity_.IsExact(guess_->velocity, now) ||
      IsReached(guess_->velocity, now, stamp_s - guess_->stamp_s)) {
    return false;
  }
  guess_->velocity = now;
  const CeilingTracker::Frame again = ceiling_.Analyze(
      view_.Rectify(guess_->up, rectified_, now), guess_->stamp_s, guess_->encoding);
  ceiling_.SetReference(again);
  corrected_ = CorrectedImage{guess_->stamp_s, again.image, now};
  return true;
}

ShutterTracker::Measurement ShutterTracker::Measure(const TiltFrame& frame, const Before& before) {
  constexpr int kMaxAgain = 2;
  corrected_.reset();
  Measurement result;
  const std::optional<Twist2> expected = Expected(frame, before.measured);
  result.assumed = expected.value_or(Twist2{});
  for (int again = 0;; ++again) {
    result.frame = ceiling_.Analyze(
        view_.Rectify(frame.up, rectified_, result.assumed), frame.stamp_s, frame.encoding);
    result.motion = ceiling_.Measure(result.frame);
    if (!view_.HasRollingShutter() || !result.motion || before.frame == nullptr) return result;
    const StampedTwist2 mean = MeanVelocity(*before.frame, result.frame);
    if (expected && IsElsewhere(*expected, mean.velocity)) {
      result.motion.reset();
      return result;
    }
    const ShutterVelocity::Estimate now = velocity_.With(mean, frame.stamp_s);
    const bool corrected = again < kMaxAgain && CorrectGuess(now.velocity, frame.stamp_s);
    if (again == kMaxAgain || (!corrected && velocity_.IsExact(result.assumed, now.velocity))) {
      guess_.reset();
      velocity_.Add(mean);
      result.tilt_variance = now.tilt_variance;
      result.motion->covariance += now.tilt_variance * Eigen::Matrix2d::Identity();
      return result;
    }
    result.assumed = now.velocity;
  }
}

void ShutterTracker::Begin(const TiltFrame& frame, const Twist2& assumed) {
  if (!view_.HasRollingShutter()) return;
  guess_ = Guess{frame.up.clone(), frame.stamp_s, frame.encoding, assumed};
}

std::optional<CorrectedImage> ShutterTracker::TakeCorrected() {
  return std::exchange(corrected_, std::nullopt);
}

}  // namespace ceilmap::compensation
