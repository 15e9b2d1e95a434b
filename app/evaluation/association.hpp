#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "calib/base/stamped_pose.hpp"

namespace ceilmap::evaluation {

/// Index pairs (truth, estimate) of the poses nearest in time: each estimate is assigned to the
/// nearest truth within max_dt_s, and each truth is used at most once. In order of rising stamps.
/// @param truth, estimate  Stamps strictly increasing. Cost: n log n.
std::vector<std::pair<std::size_t, std::size_t>> MatchStamps(
    const std::vector<StampedPose>& truth,
    const std::vector<StampedPose>& estimate,
    double max_dt_s);

}  // namespace ceilmap::evaluation
