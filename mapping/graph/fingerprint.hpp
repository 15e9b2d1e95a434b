#pragma once

#include <cstdint>
#include <span>

#include "mapping/graph/keyframe.hpp"

namespace ceilmap::graph {

/// Identifies the content of a map that measurements against it depend on: the ids and poses of its
/// keyframes, and its edges, bit by bit and in their order. Equal on all machines; the same for a
/// copy of a map file, different for a map that was made again or extended. FNV-1a of 64 bits: it
/// detects mistakes, not forgeries.
std::uint64_t Fingerprint(std::span<const Keyframe> keyframes, std::span<const Edge> edges);

}  // namespace ceilmap::graph
