#include "mapping/frame_prediction.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {
namespace {

/// The motion with another turn, driven on the same arc: half of the difference turns its chord.
Pose2 Turned(const Pose2& motion, double turn_rad) {
  const Pose2 half{0, 0, 0.5 * calib::WrapAngle(turn_rad - motion.yaw)};
  const Eigen::Vector2d chord = half.Rotation() * motion.Translation();
  return {chord.x(), chord.y(), turn_rad};
}

}  // namespace

FramePrediction::FramePrediction(const calib::CeilingView& view,
                                 const Pose2& origin,
                                 const OdometryParams& params)
    : view_(view), params_(params), compass_(params.heading_noise_rad), T_last_seen_(origin) {}

void FramePrediction::Begin(double stamp_s, const std::optional<calib::HeadingPrior>& heading) {
  stamp_s_ = stamp_s;
  heading_ = heading.has_value();
  if (heading) compass_.See(*heading);
}

/// Since the last placed frame. That one may have had no heading, but an earlier one did.
std::optional<calib::HeadingTurn> FramePrediction::Turn() const {
  auto turn = heading_ ? compass_.Turn() : std::nullopt;
  if (turn) turn->turn_rad = calib::WrapAngle(turn->turn_rad + marked_yaw_ - T_last_seen_.yaw);
  return turn;
}

std::optional<ExpectedPose> FramePrediction::Next() {
  predicted_.reset();
  if (!last_) return std::nullopt;
  ExpectedPose expected{last_->T_map_base, Sigma(), params_.prior_sigma_rad};
  Pose2 motion;
  if (before_last_) {
    const double step_s = last_->stamp_s - before_last_->stamp_s;
    const double ahead_s = stamp_s_ - last_->stamp_s;
    // After a gap the speed is not known any more: the robot may have stopped or turned.
    if (step_s > 0 && ahead_s <= 3 * step_s) {
      const Pose2 step = before_last_->T_map_base.Inverse() * last_->T_map_base;
      motion = Interpolate(step, ahead_s / step_s);
      predicted_ = last_->T_map_base * motion;
      expected.T_map_base = *predicted_;
    }
  }
  const auto compass = Turn();
  const double most = params_.prior_sigma_rad;
  if (!compass || compass->variance_rad2 >= most * most) return expected;
  // Up to here compass and speed mean the same quarter turn, and either may be the one that is off.
  constexpr double kSameSigmas = 2.5;
  const double off = std::abs(calib::WrapAngle(compass->turn_rad - motion.yaw));
  expected.by_compass_alone = off > kSameSigmas * most;
  expected.T_map_base = last_->T_map_base * Turned(motion, compass->turn_rad);
  expected.sigma_rad = std::sqrt(compass->variance_rad2);
  if (!expected.by_compass_alone) expected.sigma_rad = std::max(expected.sigma_rad, off);
  if (predicted_) predicted_ = expected.T_map_base;
  return expected;
}

std::optional<ExpectedPose> FramePrediction::AfterLoss() const {
  const auto compass = Turn();
  if (!compass || !last_seen_s_) return std::nullopt;
  const double side_px = std::max(view_.Size().width, view_.Size().height);
  const double gone_s = stamp_s_ - *last_seen_s_;
  const double known_px = params_.prior_sigma_part * side_px;
  const double strayed_px = params_.unseen_speed_part * side_px * gone_s;
  ExpectedPose expected{T_last_seen_};
  expected.T_map_base.yaw = calib::WrapAngle(T_last_seen_.yaw + compass->turn_rad);
  expected.sigma_px = std::hypot(known_px, strayed_px, speed_px_s_ * gone_s);
  expected.sigma_rad = std::sqrt(compass->variance_rad2);
  expected.by_compass_alone = true;
  return expected;
}

Pose2 FramePrediction::Restart() const {
  const auto compass = Turn();
  if (!compass) return T_last_seen_;
  return {T_last_seen_.x, T_last_seen_.y, calib::WrapAngle(T_last_seen_.yaw + compass->turn_rad)};
}

/// Robots move evenly from frame to frame: on a periodic ceiling that tells one period from the
/// next, even short ones.
double FramePrediction::Sigma() const {
  const double most = params_.prior_sigma_part * std::max(view_.Size().width, view_.Size().height);
  if (!error_px_) return most;
  const double sigma = params_.prior_sigma_errors * *error_px_;
  return std::min(most, std::max(sigma, params_.min_prior_sigma_px));
}

void FramePrediction::Placed(const Pose2& T_map_base) {
  if (predicted_) {
    constexpr double kKept = 0.9;  // a frame: forgotten after a second or two
    const double error_px =
        (predicted_->Translation() - T_map_base.Translation()).norm() / view_.MetresPerPixel();
    error_px_ = std::max(error_px, kKept * error_px_.value_or(0));
  }
  predicted_.reset();
  before_last_ = last_;
  last_ = Seen{T_map_base, stamp_s_};
  speed_px_s_ = 0;
  if (before_last_ && last_->stamp_s > before_last_->stamp_s) {
    const double way = (T_map_base.Translation() - before_last_->T_map_base.Translation()).norm();
    speed_px_s_ = way / view_.MetresPerPixel() / (last_->stamp_s - before_last_->stamp_s);
  }
  T_last_seen_ = T_map_base;
  last_seen_s_ = stamp_s_;
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
