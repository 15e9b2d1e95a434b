#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "calib/base/stamped_pose.hpp"

namespace ceilmap::evaluation {

/// Positions (truth, estimate) of poses nearest in time: each estimate goes to the nearest truth
/// that is within max_dt_s, each truth takes one. By rising stamps.
/// @param truth, estimate  stamps strictly increasing. Cost: n log n.
std::vector<std::pair<std::size_t, std::size_t>> MatchStamps(
    const std::vector<StampedPose>& truth,
    const std::vector<StampedPose>& estimate,
    double max_dt_s);

}  // namespace ceilmap::evaluation
