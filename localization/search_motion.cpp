// The motion of the hypotheses from image to image.

#include <utility>

#include "localization/global_search.hpp"

namespace ceilmap::localization {

namespace {

// A robot moves on as before for at most this number of frames, each after at most this time.
constexpr int kMaxPredicted = 5;
constexpr double kMaxStepS = 0.3;
constexpr double kStepSigmas = 4;

/// The middle of two estimates of which one is wrong.
PoseWithCovariance Either(const PoseWithCovariance& a, const PoseWithCovariance& b) {
  const Eigen::Vector3d half =
      0.5 *
      Eigen::Vector3d(b.pose.x - a.pose.x, b.pose.y - a.pose.y, WrapAngle(b.pose.yaw - a.pose.yaw));
  return {{a.pose.x + half.x(), a.pose.y + half.y(), WrapAngle(a.pose.yaw + half.z())},
          0.5 * (a.covariance + b.covariance) + half * half.transpose()};
}

}  // namespace

/// A robot that is followed, whose velocity is not known yet: the next frame may show it. Its pose
/// waits until then.
bool GlobalSearch::MayWait(double unplaced_s) const {
  return hypotheses_.Follows() && !velocity_.IsKnown() && waiting_s_ + unplaced_s <= kMaxStepS;
}

/// The way of a pose that waited, now that the velocity is known.
void GlobalSearch::MoveAsNow() {
  if (waiting_s_ > 0) {
    const PoseWithCovariance step = velocity_.MoveOn(waiting_s_);
    submap_.Move(step.pose);
    hypotheses_.Move(step.pose, step.covariance, true);
  }
  waiting_s_ = 0;
}

/// Where a robot that is followed shows too little for a step: it moves on as before, for a few
/// frames. False where that is not known.
bool GlobalSearch::MoveOn(const LevelFrame& frame, double unplaced_s) {
  if (!velocity_.IsKnown() || !hypotheses_.Follows() || unplaced_s > kMaxStepS ||
      ++predicted_ > kMaxPredicted) {
    return false;
  }
  moved_on_from_ = hypotheses_.Followed()->pose;
  const PoseWithCovariance step = velocity_.MoveOn(unplaced_s);
  submap_.Move(step.pose);
  hypotheses_.Move(step.pose, step.covariance, true);
  StartChain(hypotheses_.Followed()->pose, frame);
  return true;
}

/// Where the motion could not be measured: a new chain and the submap continue with that before,
/// for a few frames. A longer way would distort the submap, which begins anew.
void GlobalSearch::Bridge(double unplaced_s) {
  if (velocity_.IsKnown() && unplaced_s <= kMaxStepS && ++predicted_ <= kMaxPredicted) {
    submap_.Move(velocity_.MoveOn(unplaced_s).pose);
    chain_.Continue(*velocity_.Velocity());
  } else {
    velocity_.Forget();
    RestartSubmap();
  }
}

/// Wheels know the length of a step better than a ceiling at unknown heights, which knows the turn
/// better. Where both contradict each other, either may be wrong: the wheels slip, or what moves in
/// the images is a fan.
void GlobalSearch::MoveByWheels(const LevelFrame& frame,
                                const std::optional<ChainStep>& step,
                                const wheels::RelativeMotion& wheels,
                                double unplaced_s) {
  PoseWithCovariance moved{wheels.T_before_now, wheels.Covariance()};
  // Encoders have steps, stamps have errors.
  constexpr double kMinSigmaM = 1e-3;
  constexpr double kMinSigmaRad = 1e-3;
  moved.covariance.diagonal() += Eigen::Vector3d(
      kMinSigmaM * kMinSigmaM, kMinSigmaM * kMinSigmaM, kMinSigmaRad * kMinSigmaRad);
  if (step && !step->disambiguated_by_prior) {
    const Eigen::Vector2d length = Hypotheses::kStepScaleSigma * step->T_before_now.Translation();
    PoseWithCovariance seen{step->T_before_now, step->covariance};
    seen.covariance.topLeftCorner<2, 2>() += length * length.transpose();
    moved = SquaredDistance(seen, moved) < kStepSigmas * kStepSigmas ? Fused(seen, moved)
                                                                     : Either(seen, moved);
  }
  if (unplaced_s > 0) {
    velocity_.Take(moved.pose, moved.covariance, unplaced_s);
    MoveAsNow();
  }
  predicted_ = 0;
  submap_.Move(moved.pose);
  const double length_m = wheels.T_before_now.Translation().norm();
  const double scale_sigma = length_m > 0 ? wheels.common.col(0).head<2>().norm() / length_m : 0;
  hypotheses_.Move(moved.pose, moved.covariance, true, scale_sigma);
  if (step || !hypotheses_.Follows()) return;
  StartChain(hypotheses_.Followed()->pose, frame);
}

/// Where the motion was not measured, but the map shows the pose again.
void GlobalSearch::LearnVelocity(double duration_s) {
  const Hypothesis* followed = hypotheses_.Followed();
  if (!moved_on_from_ || followed == nullptr || !followed->recognised || !(duration_s > 0)) return;
  const PoseWithCovariance& now = followed->pose;
  Eigen::Matrix3d to_base = Eigen::Matrix3d::Identity();
  to_base.topLeftCorner<2, 2>() = moved_on_from_->pose.Rotation().transpose();
  velocity_.Take(moved_on_from_->pose.Inverse() * now.pose,
                 to_base * (moved_on_from_->covariance + now.covariance) * to_base.transpose(),
                 duration_s);
  predicted_ = 0;
}

/// Moves the hypotheses by the robot's own motion, if it can be measured. False when the image has
/// no texture, or the pose waits for the next one.
bool GlobalSearch::Move(const LevelFrame& frame,
                        const std::optional<wheels::RelativeMotion>& wheels,
                        Result& result) {
  constexpr double kMaxDropoutS = 1;  // after a longer dropout the robot may have been carried
  const double stamp_s = frame.stamp_s;
  if (!begin_s_) begin_s_ = stamp_s;
  LevelFrame level = frame;
  // An unmeasured tilt displaces one pose, not all that follow.
  if (hypotheses_.Follows()) level.tilt.covariance.setZero();
  const std::optional<ChainStep> step = chain_.Next(level);
  new_keyframe_ = step && step->new_keyframe;
  const double unplaced_s = stamp_s - last_placed_s_.value_or(*begin_s_);
  constexpr double kClearRatio = 0.6;
  result.elsewhere = step && !step->weak && step->inlier_ratio > kClearRatio;
  const bool shows = step || chain_.Began() || hypotheses_.Follows();
  if (wheels) {
    MoveByWheels(frame, step, *wheels, unplaced_s);
    if (velocity_.IsKnown()) {
      result.velocity = {stamp_s - unplaced_s / 2, *velocity_.Velocity()};
    }
    last_placed_s_ = stamp_s;
    return shows;
  }
  if (!shows) return false;
  bool waits = false;
  if (step) {
    if (unplaced_s > 0) {
      velocity_.Take(step->T_before_now, step->covariance, unplaced_s);
      MoveAsNow();
      predicted_ = 0;
      result.velocity = {stamp_s - unplaced_s / 2, *velocity_.Velocity()};
    }
    submap_.Move(step->T_before_now);
    hypotheses_.Move(*step, !step->disambiguated_by_prior && unplaced_s < kMaxDropoutS);
  } else if (MoveOn(frame, unplaced_s)) {
    result.velocity = {stamp_s, *velocity_.Velocity()};
  } else if (unplaced_s > 0 && MayWait(unplaced_s)) {
    waiting_s_ += unplaced_s;
    waits = true;
  } else if (unplaced_s > 0) {
    const double unknown_s = unplaced_s + std::exchange(waiting_s_, 0);
    Bridge(unplaced_s);
    hypotheses_.Spread(params_.speed_noise_when_lost_m_s * unknown_s,
                       kTurnNoiseWhenLost * unknown_s);
  }
  last_placed_s_ = stamp_s;
  return !waits;
}

}  // namespace ceilmap::localization
