#include "localization/wheel_prediction.hpp"

#include <cmath>

namespace ceilmap::localization {

namespace {

constexpr int kMaxContradictions = 10;

}  // namespace

void WheelPrediction::Start(const PoseWithCovariance& measured) {
  start_ = measured;
  motion_ = wheels::RelativeMotion{};
  contradictions_ = 0;
}

void WheelPrediction::Stop() {
  motion_.reset();
}

void WheelPrediction::Move(const std::optional<wheels::RelativeMotion>& step) {
  motion_ = wheels::Joined(motion_, step);
}

void WheelPrediction::Contradict(bool contradicts) {
  contradictions_ = contradicts ? contradictions_ + 1 : 0;
  if (contradictions_ >= kMaxContradictions) Stop();
}

std::optional<PoseWithCovariance> WheelPrediction::Pose() const {
  if (!motion_) return std::nullopt;
  const PoseWithCovariance pose = motion_->From(start_);
  return wheels::IsUsable(pose) ? std::optional(pose) : std::nullopt;
}

}  // namespace ceilmap::localization
