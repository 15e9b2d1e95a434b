#pragma once

#include <numbers>

namespace ceilmap {

/// Angles are radians everywhere; degrees occur only in files and printed text, converted there.
inline constexpr double kDegPerRad = 180 / std::numbers::pi;
inline constexpr double kRadPerDeg = std::numbers::pi / 180;

}  // namespace ceilmap
