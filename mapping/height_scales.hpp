#pragma once

#include <cstdint>
#include <unordered_map>

#include "calib/ceiling_view.hpp"
#include "mapping/graph/map_graph.hpp"

namespace ceilmap::mapping {

/// Factors by which the translations that were measured against each keyframe must be multiplied,
/// and its height ratios divided, so that all keyframes have the scale of the reference plane.
///
/// The odometry passes the scale of heights from keyframe to keyframe, with an error that grows.
/// Two keyframes that see the same things show the ratio of their scales, and each keyframe shows,
/// less accurately, which of its heights belong to the reference plane. All of these measurements
/// together are solved for ln(factor) by robust least squares; cost linear in keyframes and edges.
///
/// @return  by keyframe id; keyframes without heights have no entry.
std::unordered_map<std::int64_t, double> ConsistentScales(const calib::CeilingView& view,
                                                          const graph::MapGraph& graph);

}  // namespace ceilmap::mapping
