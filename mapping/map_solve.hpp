#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mapping/graph/map_graph.hpp"
#include "mapping/graph/pose_graph.hpp"
#include "mapping/map_match.hpp"
#include "mapping/map_union.hpp"

/// One map of many, from matches of pairs: no images are compared.
namespace ceilmap::mapping {

/// A match and its name in messages: that of its file.
struct NamedMatch {
  MapMatch match;
  std::string name;
};

/// The union of maps that matches connect.
struct SolvedMaps {
  /// A map that is not part of the union, and why.
  struct LeftOutMap {
    std::size_t map = 0;
    std::string reason;
  };
  /// Two maps that were joined by themselves, but contradict the others.
  struct Contradiction {
    std::size_t a = 0;
    std::size_t b = 0;
    std::string reason;
  };
  std::vector<std::size_t> joined;  ///< indices of the maps, increasing; fewer than two: no union
  std::vector<LeftOutMap> left_out;
  std::vector<Contradiction> contradictions;
  /// In the frame of the first joined map. The keyframe ids of each map follow those of the map
  /// before. Edges are between the bases of their own maps (WriteSolved changes them).
  graph::MapGraph graph;
  std::vector<std::int64_t> first_ids;  ///< of the keyframes of each map
};

/// Optimizes the keyframes of all maps together, with the edges of the maps and of the matches.
/// The union is that of the largest group of connected maps (most keyframes). Matches that
/// contradict others are not used: the relative poses of maps in a cycle must close, and more than
/// two thirds of the edges of each match must agree with the optimum. The order of maps and matches
/// does not change which maps are joined. A single map is optimized alone.
/// @param maps  all different. @param matches  at most one of two maps, in any order.
/// @throws InputError naming the match, when its maps are not among `maps` or have other content,
/// and when maps cannot be used together.
SolvedMaps SolveMaps(const std::vector<NamedMap>& maps,
                     const std::vector<NamedMatch>& matches,
                     const graph::PoseGraphParams& params = {});

/// Writes the union to the writer (without Commit), without a mosaic: mosaic::UndrawnMap draws it.
/// @param maps  as given to SolveMaps. @param view  CommonView of the joined maps.
/// @return the graph as it is written.
graph::MapGraph WriteSolvedGraph(const SolvedMaps& solved,
                                 const std::vector<NamedMap>& maps,
                                 const CommonView& view,
                                 store::MapWriter& writer);

/// The same with the mosaic.
/// @param metadata  of the union, as MergeMaps. @param writer  made with `metadata`.
mosaic::WrittenMap WriteSolved(const SolvedMaps& solved,
                               const std::vector<NamedMap>& maps,
                               const CommonView& view,
                               const store::MapMetadata& metadata,
                               const MapperParams& params,
                               store::MapWriter& writer,
                               const UnionProgress& progress = {});

}  // namespace ceilmap::mapping
