#pragma once

namespace ceilmap::colour {

/// Value of `format` in the file of a colour model.
inline constexpr const char* kColourModelFormat = "ceilmap colour model";
/// Frequencies and variances are stored as whole multiples of 1 / scale.
inline constexpr double kTransitionScale = 1e5;
inline constexpr double kVarianceScale = 1e8;

}  // namespace ceilmap::colour
