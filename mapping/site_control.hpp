#pragma once

#include <vector>

#include "mapping/graph/map_graph.hpp"
#include "mapping/graph/pose_graph.hpp"
#include "mapping/survey/alignment.hpp"

namespace ceilmap::mapping {

/// Places an optimized map in its building and straightens it by the same points
/// (graph::Straighten): each point moves with the keyframe that shows it. Points that contradict
/// the others are not used; a bend of the map is not taken for a contradiction.
/// @param graph  changed; the first keyframe keeps its pose.
/// @param points  picked on the map as it is before (p_map).
/// @param reach  largest distance of a point from the keyframe that shows it, map units > 0.
/// @return the alignment of the straightened map, with the points where it has them.
/// @throws InputError as survey::Align, and for a point that no keyframe shows.
survey::Alignment ControlMap(graph::MapGraph& graph,
                             const std::vector<survey::ControlPoint>& points,
                             double reach,
                             const survey::AlignOptions& align = {},
                             const graph::PoseGraphParams& pose_graph = {});

}  // namespace ceilmap::mapping
