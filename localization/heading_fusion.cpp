#include "localization/heading_fusion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/error.hpp"
#include "calib/pose2.hpp"

namespace ceilmap::localization {

void HeadingParams::Validate() const {
  if (drift_rad2_per_s >= 0 && std::isfinite(drift_rad2_per_s)) return;
  throw calib::InputError(
      fmt::format("heading: drift_rad2_per_s = {}, must be >= 0", drift_rad2_per_s));
}

HeadingFusion::HeadingFusion(const HeadingParams& params) : params_(params) {
  params_.Validate();
}

std::optional<HeadingPrior> HeadingFusion::InMap(const HeadingPrior& measured,
                                                 double stamp_s) const {
  if (!params_.unknown_zero) return measured;
  if (!known_) return std::nullopt;
  const double drift = params_.drift_rad2_per_s * std::max(0.0, stamp_s - stamp_s_);
  return HeadingPrior{calib::WrapAngle(measured.heading_rad + zero_rad_),
                      measured.variance_rad2 + variance_rad2_ + drift};
}

void HeadingFusion::Learn(const HeadingPrior& measured,
                          double yaw_map_rad,
                          double yaw_variance_rad2,
                          double stamp_s) {
  if (!params_.unknown_zero) return;
  known_ = true;
  zero_rad_ = calib::WrapAngle(yaw_map_rad - measured.heading_rad);
  variance_rad2_ = measured.variance_rad2 + yaw_variance_rad2;
  stamp_s_ = stamp_s;
}

}  // namespace ceilmap::localization
