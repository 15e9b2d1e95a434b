#include "calib/base/velocity_predictor.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap {
namespace {

// More than wheels on a floor reach.
constexpr double kMaxAcceleration = 8;      // m/s^2
constexpr double kMaxYawAcceleration = 20;  // rad/s^2
constexpr double kMaxAgeSeconds = 0.5;
// Over more intervals than these a change of velocity does not go on: its noise would grow with
// them.
constexpr double kMaxSteps = 3;

bool IsReached(const StampedTwist2& before, const StampedTwist2& now) {
  const double seconds = now.stamp_s - before.stamp_s;
  const Twist2& a = before.velocity;
  const Twist2& b = now.velocity;
  return (b.linear_m_s - a.linear_m_s).norm() <= kMaxAcceleration * seconds &&
         std::abs(b.yaw_rad_s - a.yaw_rad_s) <= kMaxYawAcceleration * seconds;
}

}  // namespace

void VelocityPredictor::Add(const StampedTwist2& measured) {
  const bool fresh = last_ && measured.stamp_s - last_->stamp_s <= kMaxAgeSeconds;
  if (fresh && !left_out_ && !IsReached(*last_, measured)) {
    left_out_ = true;
    return;
  }
  before_.reset();
  if (fresh && !left_out_) before_ = last_;
  last_ = measured;
  left_out_ = false;
}

void VelocityPredictor::AddPose(const std::optional<Pose2>& T_map_base, double stamp_s) {
  if (T_map_base && placed_ && stamp_s > placed_->stamp_s) {
    const double duration_s = stamp_s - placed_->stamp_s;
    Add({stamp_s - duration_s / 2,
         Twist2::Mean(placed_->T_map_base.Inverse() * *T_map_base, duration_s)});
  }
  placed_.reset();
  if (T_map_base) placed_ = {*T_map_base, stamp_s};
}

std::optional<Twist2> VelocityPredictor::At(double stamp_s) const {
  if (!last_ || stamp_s - last_->stamp_s > kMaxAgeSeconds) return std::nullopt;
  Twist2 velocity = last_->velocity;
  if (!before_) return velocity;
  const Twist2& before = before_->velocity;
  const double ratio =
      std::min(kMaxSteps, (stamp_s - last_->stamp_s) / (last_->stamp_s - before_->stamp_s));
  velocity.linear_m_s += ratio * (velocity.linear_m_s - before.linear_m_s);
  velocity.yaw_rad_s += ratio * (velocity.yaw_rad_s - before.yaw_rad_s);
  return velocity;
}

}  // namespace ceilmap
