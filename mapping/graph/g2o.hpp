#pragma once

#include <string>

#include "mapping/graph/map_graph.hpp"

namespace ceilmap::graph {

/// The pose graph of a map as g2o text, the format that other solvers read: VERTEX_SE2 id x y yaw,
/// FIX id, and EDGE_SE2 from to x y yaw ixx ixy ixyaw iyy iyyaw iyawyaw. Vertices keep their
/// keyframes' ids, and the first one is fixed. Numbers are written with as many digits as are
/// needed to read the same values back, in any locale.
std::string FormatG2o(const MapGraph& graph);

}  // namespace ceilmap::graph
