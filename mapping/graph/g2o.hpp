#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/pose2.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/map_graph.hpp"

/// Pose graphs as g2o text, the format that other solvers read: VERTEX_SE2 id x y yaw, FIX id, and
/// EDGE_SE2 from to x y yaw ixx ixy ixyaw iyy iyyaw iyawyaw.
namespace ceilmap::graph {

struct PoseGraph {
  std::vector<Pose2> poses;  ///< T_map_base by keyframe id
  std::vector<Edge> edges;
  std::vector<std::int64_t> fixed;
};

/// The graph as text. Numbers are written with as many digits as are needed to read the same values
/// back, in any locale.
std::string FormatG2o(std::span<const Pose2> poses,
                      std::span<const Edge> edges,
                      std::span<const std::int64_t> fixed = {});

/// The same for a map: vertices keep their keyframes' ids, the first one is fixed.
std::string FormatG2o(const MapGraph& graph);

/// Reads such text; vertices and edges may come in any order, '#' begins a comment line. The format
/// does not distinguish odometry from loop closures: an edge to the next keyframe is taken as
/// odometry.
///
/// @param file  Name used in messages.
/// @throws InputError with FILE:LINE for a line that is malformed or of another kind, for
///   ids that are not 0, 1, 2, ... once each, and for information that is not positive definite.
PoseGraph ParseG2o(std::string_view text, const std::string& file);

}  // namespace ceilmap::graph
