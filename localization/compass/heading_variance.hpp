#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ceilmap::compass {

/// Beyond this a heading is any heading, rad^2.
inline constexpr double kAnyHeading = std::numbers::pi * std::numbers::pi;

/// Variance of a heading measured against a reference whose own heading is uncertain, rad^2.
/// Standard deviations add, not variances: what travel does to the panorama is the same from one
/// reference to the next (successive errors on recordings correlate by 0.7 to 0.95), so that errors
/// pile up instead of cancelling.
inline double ChainedVariance(double reference_rad2, double measured_rad2) {
  const double sigma = std::sqrt(reference_rad2) + std::sqrt(measured_rad2);
  return std::min(sigma * sigma, kAnyHeading);
}

/// Variance of a heading that has been held for `elapsed_s` because nothing could be measured.
/// @param rate_rad_s  Standard deviation of the rate at which the robot may turn meanwhile, which
///   may last: standard deviations add here too, so that two spells are one long one.
inline double HeldVariance(double before_rad2, double rate_rad_s, double elapsed_s) {
  const double sigma = rate_rad_s * elapsed_s;
  return ChainedVariance(before_rad2, sigma * sigma);
}

}  // namespace ceilmap::compass
