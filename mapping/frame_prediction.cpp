#include "mapping/frame_prediction.hpp"

#include <algorithm>
#include <cmath>

#include "calib/base/pose_with_covariance.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {
namespace {

// Standard deviations of the prediction, for the choice among equally good motions on periodic
// ceilings: of the shift as a fraction of the image's longer side, and of the yaw.
constexpr double kPriorSigmaRatio = 0.04;
constexpr double kPriorSigmaRad = 0.15;
// Once the prediction has proved more accurate than that, its own recent errors times this number
// are used as the standard deviation of the shift, and not less than this.
constexpr double kPriorSigmaErrors = 4;
constexpr double kMinPriorSigmaPx = 4;
// Standard deviation of the robot's speed while it is lost, fraction of the image's longer side
// per second. It determines the position uncertainty after a loss when only a compass is
// available.
constexpr double kUnseenSpeedRatio = 0.4;
// Acceleration and turn rate of the robot since the last placed frame, beyond the limits
// OdometryParams::uneven_ratio and uneven_rad: longer sides per s^2, and rad/s.
constexpr double kUnseenAccelerationRatio = 1.5;
constexpr double kUnseenTurnRadS = 2;
// A lost robot is searched for near its last keyframes only until it may have travelled this
// fraction of the image's longer side at `kUnseenSpeedRatio`; then a new segment begins. Until
// then only matches that pass the MatchGate are accepted.
constexpr double kMaxStrayedRatio = 1.5;

// Frames are missing where the time to the last frame is more than this multiple of the time
// between the last two frames.
constexpr double kGapSteps = 3;
// Largest number of steps to the next frame where frames are missing without a gap in the stamps.
constexpr int kMaxSteps = 9;

// Larger differences from the motion of the last step are no errors of measurement: of the image's
// longer side, and of the turn.
constexpr double kEvenRatio = 0.015;
constexpr double kEvenRad = 0.03;

/// The motion with another turn, on a circular arc of the same chord length: half of the difference
/// of turn rotates the chord.
Pose2 Turned(const Pose2& motion, double turn_rad) {
  const Pose2 half{0, 0, 0.5 * WrapAngle(turn_rad - motion.yaw)};
  const Eigen::Vector2d chord = half.Rotation() * motion.Translation();
  return {chord.x(), chord.y(), turn_rad};
}

}  // namespace

FramePrediction::FramePrediction(const calib::CeilingView& view,
                                 const Pose2& origin,
                                 const OdometryParams& params)
    : view_(view), params_(params), compass_(params.heading_noise_rad), T_last_placed_(origin) {}

void FramePrediction::Begin(double stamp_s,
                            const std::optional<HeadingPrior>& heading,
                            const std::optional<wheels::RelativeMotion>& wheels) {
  Skip(wheels);
  gap_s_ = given_stamp_s_ ? stamp_s - *given_stamp_s_ : 0;
  given_stamp_s_ = stamp_s;
  stamp_s_ = stamp_s + missing_s_;
  heading_ = heading.has_value();
  if (heading) compass_.Add(*heading);
}

void FramePrediction::Skip(const std::optional<wheels::RelativeMotion>& wheels) {
  wheels_ = wheels::Joined(wheels_, wheels);
}

/// Turn since the last placed frame. That frame may have no heading; then the turn is counted from
/// an earlier frame that has one.
std::optional<HeadingTurn> FramePrediction::Turn() const {
  auto turn = heading_ ? compass_.Turn() : std::nullopt;
  if (turn) turn->turn_rad = WrapAngle(turn->turn_rad + marked_yaw_ - T_last_placed_.yaw);
  return turn;
}

double FramePrediction::ElapsedSeconds() const {
  return last_placed_s_ ? std::abs(stamp_s_ - *last_placed_s_) : 0;
}

std::optional<ExpectedPose> FramePrediction::ByWheels() const {
  if (!wheels_) return std::nullopt;
  const Eigen::Matrix3d covariance = wheels_->Covariance();
  const double sigma_px = std::sqrt(covariance(0, 0) + covariance(1, 1)) / view_.MetresPerPixel();
  constexpr double kMinSigmaRad = 0.02;
  return ExpectedPose{T_last_placed_ * wheels_->T_before_now,
                      std::max(sigma_px, kMinPriorSigmaPx),
                      std::max(std::sqrt(covariance(2, 2)), kMinSigmaRad)};
}

bool FramePrediction::WheelsAgree(const Pose2& T_map_base) const {
  constexpr double kSigmas = 4;
  const std::optional<ExpectedPose> expected = ByWheels();
  if (!expected) return false;
  const Off off = OffFrom(expected->T_map_base, T_map_base);
  return off.px < kSigmas * expected->sigma_px && off.rad < kSigmas * expected->sigma_rad;
}

bool FramePrediction::CeilingHidden() const {
  constexpr double kKnownRatio = 0.1;  // of the longer side
  const std::optional<ExpectedPose> by_wheels = ByWheels();
  const double side_px = std::max(view_.Size().width, view_.Size().height);
  if (by_wheels && by_wheels->sigma_px < kKnownRatio * side_px) return false;
  constexpr double kHalfImage = 0.5;
  const double elapsed_s = ElapsedSeconds();
  if (kUnseenSpeedRatio * elapsed_s <= kHalfImage) return false;
  // A low frame rate (an image every few seconds) is not a gap.
  return !last_ || !before_last_ ||
         elapsed_s > kGapSteps * (last_->stamp_s - before_last_->stamp_s);
}

bool FramePrediction::MayBeNear() const {
  if (const std::optional<ExpectedPose> by_wheels = ByWheels()) {
    const double side_px = std::max(view_.Size().width, view_.Size().height);
    return OffFrom(T_last_placed_, by_wheels->T_map_base).px < kMaxStrayedRatio * side_px;
  }
  return kUnseenSpeedRatio * ElapsedSeconds() < kMaxStrayedRatio;
}

/// Difference from constant velocity at a time: the smallest one among the velocities of the last
/// step and of the last few steps, each also without the last frame, whose stamp may be wrong.
/// Nothing where no motion was measured.
std::optional<FramePrediction::Off> FramePrediction::OffEvenMotion(const Pose2& T_map_base,
                                                                   double stamp_s) const {
  std::optional<Off> smallest;
  const auto compare = [&](const PlacedFrame& from, const PlacedFrame& to) {
    const double step_s = to.stamp_s - from.stamp_s;
    if (step_s <= 0) return;
    const Pose2 step = from.T_map_base.Inverse() * to.T_map_base;
    const Pose2 even = to.T_map_base * Interpolate(step, (stamp_s - to.stamp_s) / step_s);
    const Off off = OffFrom(even, T_map_base);
    if (!smallest || off.px < smallest->px) smallest = off;
  };
  for (std::size_t skipped = 0; skipped < 2 && recent_.size() >= 2 + skipped; ++skipped) {
    const std::size_t last = recent_.size() - 1 - skipped;
    compare(recent_[last - 1], recent_[last]);
    compare(recent_.front(), recent_[last]);
  }
  return smallest;
}

FramePrediction::Off FramePrediction::OffFrom(const Pose2& expected,
                                              const Pose2& T_map_base) const {
  return {(T_map_base.Translation() - expected.Translation()).norm() / view_.MetresPerPixel(),
          std::abs(WrapAngle(T_map_base.yaw - expected.yaw))};
}

bool FramePrediction::CanBeAt(const Pose2& T_map_base) {
  if (!last_placed_s_) return true;
  // After an implausible measurement only poses near constant velocity are accepted: the time that
  // passes does not make other poses more likely.
  const double elapsed_s = contradicted_ ? 0 : ElapsedSeconds();
  const double side_px = std::max(view_.Size().width, view_.Size().height);
  const std::optional<Off> even = OffEvenMotion(T_map_base, stamp_s_);
  const Off still = OffFrom(T_last_placed_, T_map_base);
  const Off off = even ? *even : still;
  constexpr double kUnknownSpeedRatio = 0.5;  // a recording may begin at full speed
  const double max_fraction =
      even ? params_.uneven_ratio + 0.5 * kUnseenAccelerationRatio * elapsed_s * elapsed_s
           : kUnknownSpeedRatio + 2 * kUnseenSpeedRatio * elapsed_s;
  // Standing still is always plausible, except after an implausible measurement. A heading was
  // already used in the prediction, and a compass may be disturbed: with a heading the yaw is not
  // checked here.
  const bool stopped = !contradicted_ && still.px < params_.uneven_ratio * side_px;
  const bool can = (stopped || off.px < max_fraction * side_px) &&
                   (heading_ || off.rad < params_.uneven_rad + kUnseenTurnRadS * elapsed_s);
  contradicted_ = contradicted_ || !can;
  return can;
}

/// How far the pose is behind the motion of the last step, along that motion.
std::optional<FramePrediction::Off> FramePrediction::Lag(const Pose2& T_map_base) const {
  if (recent_.size() < 2) return std::nullopt;
  const PlacedFrame& from = recent_[recent_.size() - 2];
  const PlacedFrame& to = recent_.back();
  const double step_s = to.stamp_s - from.stamp_s;
  if (step_s <= 0) return std::nullopt;
  const Pose2 even =
      Interpolate(from.T_map_base.Inverse() * to.T_map_base, (stamp_s_ - to.stamp_s) / step_s);
  const Pose2 moved = to.T_map_base.Inverse() * T_map_base;
  const double length = even.Translation().norm();
  const double way = length > 0 ? moved.Translation().dot(even.Translation()) / length : 0;
  const double turned = even.yaw > 0 ? moved.yaw : -moved.yaw;
  return Off{(length - way) / view_.MetresPerPixel(), std::abs(even.yaw) - turned};
}

bool FramePrediction::FallsBehind(const Pose2& T_map_base) const {
  const std::optional<Off> lag = Lag(T_map_base);
  const double side_px = std::max(view_.Size().width, view_.Size().height);
  return lag && (lag->px > kEvenRatio * side_px || lag->rad > kEvenRad);
}

bool FramePrediction::IsUneven(const Pose2& T_map_base) const {
  const std::optional<Off> lag = Lag(T_map_base);
  const double side_px = std::max(view_.Size().width, view_.Size().height);
  return !lag || std::abs(lag->px) > kEvenRatio * side_px || std::abs(lag->rad) > kEvenRad;
}

std::optional<int> FramePrediction::StepsTo(const Pose2& T_map_base) const {
  // Of numbers of steps that explain the pose about equally well, the smallest is the likeliest.
  constexpr double kStepPenaltyPx = 1;
  if (!(gap_s_ > 0)) return std::nullopt;
  const double side_px = std::max(view_.Size().width, view_.Size().height);
  // The robot may have changed its speed or curved on the way, but not turned back.
  constexpr double kUnevenShare = 0.25;  // of the way
  const double max_px =
      params_.uneven_ratio * side_px + kUnevenShare * OffFrom(T_last_placed_, T_map_base).px;
  std::optional<int> best;
  double best_px = 0;
  for (int steps = 2; steps <= kMaxSteps; ++steps) {
    const double missing_s = (steps - 1) * gap_s_;
    const std::optional<Off> off = OffEvenMotion(T_map_base, stamp_s_ + missing_s);
    if (!off) return std::nullopt;
    if (off->px > max_px) continue;
    const double elapsed_s = ElapsedSeconds() + missing_s;
    if (!heading_ && off->rad > params_.uneven_rad + kUnseenTurnRadS * elapsed_s) continue;
    const double cost_px = off->px + kStepPenaltyPx * steps;
    if (best && cost_px >= best_px) continue;
    best = steps;
    best_px = cost_px;
  }
  return best ? best : StepsAhead(T_map_base);
}

/// A robot that turned or was slow may have driven straight ahead in the missing frames, at most as
/// fast as it was before.
std::optional<int> FramePrediction::StepsAhead(const Pose2& T_map_base) const {
  constexpr double kMaxSideways = 0.25;  // of the way ahead
  if (recent_.size() < 2 || !(fastest_px_s_ > 0)) return std::nullopt;
  const double unit = view_.MetresPerPixel();
  const double side_px = std::max(view_.Size().width, view_.Size().height);
  const auto ahead_px = [&](const Pose2& from, const Pose2& to) {
    return (from.Inverse() * to).x / unit;
  };
  const double before_px =
      ahead_px(recent_[recent_.size() - 2].T_map_base, recent_.back().T_map_base);
  const Pose2 way = T_last_placed_.Inverse() * T_map_base;
  const double way_px = way.Translation().norm() / unit;
  const bool ahead = way.x > 0 && before_px > -params_.uneven_ratio * side_px &&
                     std::abs(way.y) < kMaxSideways * way.x + params_.uneven_ratio * side_px * unit;
  if (!ahead || std::abs(way.yaw) > params_.uneven_rad) return std::nullopt;
  for (int steps = 2; steps <= kMaxSteps; ++steps) {
    if (way_px < fastest_px_s_ * (ElapsedSeconds() + (steps - 1) * gap_s_)) return steps;
  }
  return std::nullopt;
}

double FramePrediction::InnovationSigma(const Pose2& T_map_base, int steps) const {
  const double missing_s = (steps - 1) * gap_s_;
  const std::optional<Off> off = OffEvenMotion(T_map_base, stamp_s_ + missing_s);
  if (!off) return 0;
  constexpr double kExactPx = 1.5;
  constexpr double kUsualRatio = 0.1;  // of the largest accepted acceleration
  constexpr double kSigmas = 3;
  constexpr double kInflation = 0.5;  // fraction of the position error
  const double side_px = std::max(view_.Size().width, view_.Size().height);
  const double elapsed_s = ElapsedSeconds() + missing_s;
  const double sigma_px =
      kExactPx + 0.5 * kUsualRatio * kUnseenAccelerationRatio * side_px * elapsed_s * elapsed_s;
  return off->px > kSigmas * sigma_px ? kInflation * off->px * view_.MetresPerPixel() : 0;
}

std::optional<ExpectedPose> FramePrediction::Next() {
  predicted_.reset();
  if (!last_) return std::nullopt;
  ExpectedPose expected{last_->T_map_base, Sigma(), kPriorSigmaRad};
  Pose2 motion;
  if (before_last_) {
    const double step_s = last_->stamp_s - before_last_->stamp_s;
    const double ahead_s = stamp_s_ - last_->stamp_s;
    // The robot may have stopped or turned. Expected where it was, it would be found one tile of a
    // periodic ceiling away from where it is.
    if (step_s > 0 && ahead_s > kGapSteps * step_s) return AfterLoss();
    if (step_s > 0) {
      const Pose2 step = before_last_->T_map_base.Inverse() * last_->T_map_base;
      motion = Interpolate(step, ahead_s / step_s);
      predicted_ = last_->T_map_base * motion;
      expected.T_map_base = *predicted_;
    }
  }
  const auto compass = Turn();
  const double max_sigma = kPriorSigmaRad;
  if (!compass || compass->variance_rad2 >= max_sigma * max_sigma) return expected;
  // Within this limit the compass and the constant-velocity model agree on the quarter turn, and
  // either of them may have the error.
  constexpr double kSameSigmas = 2.5;
  const double off = std::abs(WrapAngle(compass->turn_rad - motion.yaw));
  expected.by_compass_alone = off > kSameSigmas * max_sigma;
  expected.T_map_base = last_->T_map_base * Turned(motion, compass->turn_rad);
  expected.sigma_rad = std::sqrt(compass->variance_rad2);
  if (!expected.by_compass_alone) expected.sigma_rad = std::max(expected.sigma_rad, off);
  if (predicted_) predicted_ = expected.T_map_base;
  return expected;
}

std::optional<ExpectedPose> FramePrediction::AfterLoss() const {
  if (wheels_) return ByWheels();
  const auto compass = Turn();
  if (!compass || !last_placed_s_) return std::nullopt;
  const double side_px = std::max(view_.Size().width, view_.Size().height);
  const double elapsed_s = stamp_s_ - *last_placed_s_;
  const double known_px = kPriorSigmaRatio * side_px;
  const double strayed_px = kUnseenSpeedRatio * side_px * elapsed_s;
  ExpectedPose expected{T_last_placed_};
  expected.T_map_base.yaw = WrapAngle(T_last_placed_.yaw + compass->turn_rad);
  expected.sigma_px = std::hypot(known_px, strayed_px, speed_px_s_ * elapsed_s);
  expected.sigma_rad = std::sqrt(compass->variance_rad2);
  expected.by_compass_alone = true;
  return expected;
}

std::optional<ExpectedPose> FramePrediction::Continued() const {
  // The robot may have changed its motion by as much as the standard deviations of the prediction.
  constexpr double kMaxLostSteps = 5;
  if (recent_.size() < 2) return std::nullopt;
  const PlacedFrame& first = recent_.front();
  const PlacedFrame& latest = recent_.back();
  const double known_s = latest.stamp_s - first.stamp_s;
  const double step_s = known_s / static_cast<double>(recent_.size() - 1);
  const double ahead_s = stamp_s_ - latest.stamp_s;
  if (!(step_s > 0) || ahead_s > kMaxLostSteps * step_s) return std::nullopt;
  const Pose2 motion = first.T_map_base.Inverse() * latest.T_map_base;
  const double side_px = std::max(view_.Size().width, view_.Size().height);
  return ExpectedPose{latest.T_map_base * Interpolate(motion, ahead_s / known_s),
                      kPriorSigmaRatio * side_px,
                      kPriorSigmaRad};
}

bool FramePrediction::MustHaveMoved() const {
  constexpr double kSteadyPx = 3;  // from frame to frame, at the border of the image
  constexpr std::size_t kMinFrames = 3;
  const std::optional<ExpectedPose> expected = Continued();
  if (!expected || recent_.size() < kMinFrames) return false;
  const double reach_px = 0.5 * std::max(view_.Size().width, view_.Size().height);
  const auto motion_px = [&](const Pose2& from, const Pose2& to) {
    const Off off = OffFrom(from, to);
    return off.px + reach_px * off.rad;
  };
  for (std::size_t i = recent_.size() - kMinFrames; i + 1 < recent_.size(); ++i) {
    if (motion_px(recent_[i].T_map_base, recent_[i + 1].T_map_base) < kSteadyPx) return false;
  }
  return motion_px(recent_.back().T_map_base, expected->T_map_base) > kSteadyPx;
}

Pose2 FramePrediction::Restart() {
  recent_.clear();
  if (wheels_) return T_last_placed_ * wheels_->T_before_now;
  const auto compass = Turn();
  if (!compass) return T_last_placed_;
  return {T_last_placed_.x, T_last_placed_.y, WrapAngle(T_last_placed_.yaw + compass->turn_rad)};
}

/// Standard deviation of the predicted position. The constant-velocity model is accurate enough to
/// resolve even short periods of a periodic ceiling.
double FramePrediction::Sigma() const {
  const double max_sigma = kPriorSigmaRatio * std::max(view_.Size().width, view_.Size().height);
  if (!error_px_) return max_sigma;
  const double sigma = kPriorSigmaErrors * *error_px_;
  return std::min(max_sigma, std::max(sigma, kMinPriorSigmaPx));
}

void FramePrediction::Continue(const Twist2& velocity) {
  if (!last_) return;
  constexpr double kStepS = 0.5;  // images may be rare
  before_last_ = PlacedFrame{last_->T_map_base * velocity.Over(-kStepS), last_->stamp_s - kStepS};
  recent_ = {*before_last_, *last_};
  constexpr double kUsualErrorPx = 2.5;
  error_px_ = kUsualErrorPx;
}

void FramePrediction::Placed(const Pose2& T_map_base, int steps) {
  const double missing_s = (steps - 1) * gap_s_;
  missing_s_ += missing_s;
  stamp_s_ += missing_s;
  if (predicted_) {
    constexpr double kKept = 0.9;  // per frame: decays within one to two seconds
    const double error_px =
        (predicted_->Translation() - T_map_base.Translation()).norm() / view_.MetresPerPixel();
    error_px_ = std::max(error_px, kKept * error_px_.value_or(0));
  }
  predicted_.reset();
  before_last_ = last_;
  last_ = PlacedFrame{T_map_base, stamp_s_};
  speed_px_s_ = 0;
  if (before_last_ && last_->stamp_s > before_last_->stamp_s) {
    const double distance =
        (T_map_base.Translation() - before_last_->T_map_base.Translation()).norm();
    speed_px_s_ = distance / view_.MetresPerPixel() / (last_->stamp_s - before_last_->stamp_s);
    if (steps == 1) fastest_px_s_ = std::max(fastest_px_s_, speed_px_s_);
  }
  T_last_placed_ = T_map_base;
  wheels_ = wheels::RelativeMotion{};
  last_placed_s_ = stamp_s_;
  contradicted_ = false;
  constexpr double kRememberedSeconds = 0.4;
  constexpr std::size_t kMinFrames = 4;
  recent_.push_back(*last_);
  while (recent_.size() > kMinFrames && stamp_s_ - recent_.front().stamp_s > kRememberedSeconds) {
    recent_.pop_front();
  }
  if (!heading_) return;
  compass_.Mark();
  marked_yaw_ = T_map_base.yaw;
}

void FramePrediction::Lost() {
  last_.reset();
  before_last_.reset();
  predicted_.reset();
  error_px_.reset();
}

}  // namespace ceilmap::mapping
