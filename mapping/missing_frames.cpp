#include "mapping/missing_frames.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ceilmap::mapping {
namespace {

constexpr std::size_t kRemembered = 9;
constexpr std::size_t kMinSpeeds = 3;
// Steps of fewer pixels are not exact enough to be counted.
constexpr double kMinStepPx = 3;
// A step belongs to a whole number of frames to within this fraction of one.
constexpr double kTolerance = 0.3;
constexpr int kMaxFrames = 10;
// After this many long steps without a usual one the robot drives faster.
constexpr std::size_t kMaxWaiting = 4;

}  // namespace

/// Some of the remembered steps may be long ones too, none is short: a low quantile.
std::optional<double> MissingFrames::UsualSpeed() const {
  if (speeds_.size() < kMinSpeeds) return std::nullopt;
  std::vector<double> sorted(speeds_.begin(), speeds_.end());
  const auto low = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 3);
  std::nth_element(sorted.begin(), low, sorted.end());
  return *low;
}

void MissingFrames::AddSpeed(double px_s) {
  speeds_.push_back(px_s);
  if (speeds_.size() > kRemembered) speeds_.pop_front();
}

void MissingFrames::Add(std::int64_t frame_index, double stamp_s, const Pose2& T_map_base) {
  const std::optional<Placed> before = last_;
  last_ = Placed{frame_index, stamp_s, T_map_base};
  if (!before || frame_index != before->frame_index + 1 || !(stamp_s > before->stamp_s)) {
    speeds_.clear();
    waiting_.clear();
    return;
  }
  const Pose2 step = before->T_map_base.Inverse() * T_map_base;
  const double reach_px = 0.5 * std::max(view_.Size().width, view_.Size().height);
  const double step_px =
      step.Translation().norm() / view_.MetresPerPixel() + reach_px * std::abs(step.yaw);
  const double px_s = step_px / (stamp_s - before->stamp_s);
  const std::optional<double> usual = UsualSpeed();
  if (!usual || step_px < kMinStepPx || !(*usual > 0)) {
    waiting_.clear();
    AddSpeed(px_s);
    return;
  }
  const double frames = px_s / *usual;
  if (frames < 1 + kTolerance) {
    // A robot that accelerated would not be as slow as before again.
    if (frames > 1 - kTolerance) {
      for (const double waiting : waiting_) count_ += std::lround(waiting) - 1;
    }
    waiting_.clear();
    AddSpeed(px_s);
    return;
  }
  const bool whole = std::abs(frames - std::round(frames)) < kTolerance * std::sqrt(frames);
  if (whole && frames < kMaxFrames && waiting_.size() < kMaxWaiting) {
    waiting_.push_back(frames);
    return;
  }
  waiting_.clear();
  speeds_.clear();
}

}  // namespace ceilmap::mapping
