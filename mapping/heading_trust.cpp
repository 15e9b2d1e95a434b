#include "mapping/heading_trust.hpp"

#include <algorithm>
#include <cmath>

#include "calib/base/field_check.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::mapping {

void HeadingTrust::Validate() const {
  const FieldCheck require("heading");
  const auto positive = [&require](const char* field, double value) {
    require(value > 0 && std::isfinite(value), field, value, "> 0");
  };
  positive("noise_rad", noise_rad);
  positive("max_sigmas", max_sigmas);
  positive("min_rad", min_rad);
}

bool Contradict(const HeadingTurn& compass, const HeadingTurn& other, const HeadingTrust& trust) {
  const double off = std::abs(WrapAngle(other.turn_rad - compass.turn_rad));
  const double sigma = std::sqrt(compass.variance_rad2 + other.variance_rad2);
  return off > std::max(trust.min_rad, trust.max_sigmas * sigma);
}

}  // namespace ceilmap::mapping
