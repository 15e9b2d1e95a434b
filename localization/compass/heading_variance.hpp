#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ceilmap::compass {

/// Upper bound of a heading's variance, rad^2: from here on the heading is unknown.
inline constexpr double kAnyHeading = std::numbers::pi * std::numbers::pi;

/// Variance of a heading measured against a reference whose own heading is uncertain, rad^2.
/// Standard deviations are added, not variances: the effect of travel on the panorama is the same
/// from one reference to the next, so that successive errors are strongly correlated and accumulate
/// instead of cancelling.
inline double ChainedVariance(double reference_rad2, double measured_rad2) {
  const double sigma = std::sqrt(reference_rad2) + std::sqrt(measured_rad2);
  return std::min(sigma * sigma, kAnyHeading);
}

/// Variance of a heading that has been held for `elapsed_s` because nothing could be measured.
/// @param rate_rad_s  Standard deviation of the robot's turn rate in this time. The rate may
///   persist, so standard deviations are added here too, and two successive intervals are
///   equivalent to one long interval.
inline double HeldVariance(double before_rad2, double rate_rad_s, double elapsed_s) {
  const double sigma = rate_rad_s * elapsed_s;
  return ChainedVariance(before_rad2, sigma * sigma);
}

}  // namespace ceilmap::compass
