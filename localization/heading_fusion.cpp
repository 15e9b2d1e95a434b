#include "localization/heading_fusion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::localization {

void HeadingParams::Validate() const {
  if (!(drift_rad2_per_s >= 0 && std::isfinite(drift_rad2_per_s))) {
    throw InputError(fmt::format("heading: drift_rad2_per_s = {}, must be >= 0", drift_rad2_per_s));
  }
  if (!(noise_rad > 0 && std::isfinite(noise_rad))) {
    throw InputError(fmt::format("heading: noise_rad = {}, must be > 0", noise_rad));
  }
}

HeadingFusion::HeadingFusion(const HeadingParams& params)
    : params_(params), since_(params.noise_rad) {
  params_.Validate();
}

std::optional<HeadingPrior> HeadingFusion::InMap(const HeadingPrior& measured, double stamp_s) {
  if (measured.frame == HeadingFrame::kMap) return measured;
  since_.Add(measured);
  const std::optional<HeadingTurn> turn = since_.Turn();
  if (!known_ || !turn) return std::nullopt;
  const double drift = params_.drift_rad2_per_s * std::max(0.0, stamp_s - stamp_s_);
  return HeadingPrior{WrapAngle(yaw_rad_ + turn->turn_rad),
                      turn->variance_rad2 + yaw_variance_rad2_ + drift,
                      measured.frame};
}

void HeadingFusion::Learn(const HeadingPrior& measured,
                          double yaw_map_rad,
                          double yaw_variance_rad2,
                          double stamp_s) {
  if (measured.frame == HeadingFrame::kMap) return;
  since_.Add(measured);
  since_.Mark();
  known_ = true;
  yaw_rad_ = yaw_map_rad;
  yaw_variance_rad2_ = yaw_variance_rad2;
  stamp_s_ = stamp_s;
}

void HeadingFusion::Forget() {
  known_ = false;
  since_ = HeadingSince(params_.noise_rad);
}

}  // namespace ceilmap::localization
