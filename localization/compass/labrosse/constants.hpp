#pragma once

#include <numbers>

namespace ceilmap::labrosse {

inline constexpr double kTurn = 2 * std::numbers::pi;  // of the robot, rad

// A panorama with less texture along its rows than this (RowTexture, grey levels, >= 0) gives no
// information: it is uniform except for noise.
inline constexpr double kMinTexture = 2;
// Width over which the differences of two panoramas count as one independent error, rad, > 0: 4
// deg. Only the variance depends on it.
inline constexpr double kIndependentRad = std::numbers::pi / 45;
// Standard deviation of the robot's turn rate while nothing can be measured, rad/s, > 0.
inline constexpr double kUnseenRateRadS = 0.5;

}  // namespace ceilmap::labrosse
