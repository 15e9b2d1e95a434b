#include "mapping/heading_trust.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::mapping {

void HeadingTrust::Validate() const {
  const auto require = [](const char* field, double value) {
    if (!(value > 0 && std::isfinite(value))) {
      throw InputError(fmt::format("heading: {} = {}, must be > 0", field, value));
    }
  };
  require("noise_rad", noise_rad);
  require("max_sigmas", max_sigmas);
  require("least_rad", min_rad);
}

bool Contradict(const HeadingTurn& compass, const HeadingTurn& other, const HeadingTrust& trust) {
  const double off = std::abs(WrapAngle(other.turn_rad - compass.turn_rad));
  const double sigma = std::sqrt(compass.variance_rad2 + other.variance_rad2);
  return off > std::max(trust.min_rad, trust.max_sigmas * sigma);
}

}  // namespace ceilmap::mapping
