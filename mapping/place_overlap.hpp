#pragma once

#include <cstdint>
#include <span>

#include "mapping/map_joiner.hpp"

namespace ceilmap::mapping {

/// Whether two parts of a map may show a common piece of ceiling, by their place descriptors alone:
/// some images of b have several windows that correspond to those of one image of a under one
/// motion. Parts of other ceilings rarely do; parts with a common area, or under ceilings that
/// repeat, always did in the measurements of tests/bench/README.md ("Pruning"). When in doubt:
/// true. Takes about a millisecond for each keyframe, a hundredth of JoinParts.
bool MayMeet(std::span<const std::int64_t> a,
             std::span<const std::int64_t> b,
             const DescriptorSource& descriptors);

}  // namespace ceilmap::mapping
