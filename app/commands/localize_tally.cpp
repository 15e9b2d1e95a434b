#include "app/commands/localize_tally.hpp"

#include <cmath>

namespace ceilmap::commands {

void LocalizeTally::Add(const robot::Estimate& estimate, reports::LocalizeResult& result) {
  if (!first_stamp_s_) first_stamp_s_ = estimate.stamp_s;
  if (!estimate.HasPose()) {
    had_pose_ = false;
    return;
  }
  if (!result.first_placed_s) {
    result.first_placed_s = estimate.stamp_s - *first_stamp_s_;
    result.first_placed_frame = estimate.index;
  }
  const auto& [pose, covariance] = estimate.pose;
  if (had_pose_) result.path_m += (pose.Translation() - last_.Translation()).norm();
  had_pose_ = true;
  last_ = pose;
  variances_ += 0.5 * (covariance(0, 0) + covariance(1, 1));
  ++placed_;
  result.mean_sigma_m = std::sqrt(variances_ / static_cast<double>(placed_));
}

}  // namespace ceilmap::commands
