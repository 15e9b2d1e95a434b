#include "localization/compass/travel_forecast.hpp"

namespace ceilmap::compass {
namespace {

constexpr double kMaxAgeS = 1;

}  // namespace

void TravelForecast::Add(double stamp_s, const std::optional<Pose2>& T_map_base) {
  if (last_ && !(stamp_s > last_s_)) return;
  velocity_m_s_.reset();
  if (last_ && T_map_base && stamp_s - last_s_ <= kMaxAgeS) {
    velocity_m_s_ = (camera_ - T_map_base->Inverse() * (*last_ * camera_)) / (stamp_s - last_s_);
  }
  last_ = T_map_base;
  last_s_ = stamp_s;
}

std::optional<Eigen::Vector2d> TravelForecast::Between(double from_s, double to_s) const {
  if (!velocity_m_s_ || to_s - last_s_ > kMaxAgeS) return std::nullopt;
  return (to_s - from_s) * *velocity_m_s_;
}

}  // namespace ceilmap::compass
