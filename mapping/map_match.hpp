#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mapping/common_view.hpp"
#include "mapping/map_joiner.hpp"
#include "mapping/mapper.hpp"

/// Measures the relative pose of two maps.
namespace ceilmap::mapping {

/// Identifies a map of a MapMatch.
struct MatchedMap {
  std::string name;               ///< of its file, without the folder; for messages
  std::uint64_t fingerprint = 0;  ///< graph::Fingerprint of its content
};

/// The relative pose of two maps and the edges between them, or why there are none.
struct MapMatch {
  MatchedMap a;
  MatchedMap b;
  /// T_a_b: the rigid motion that fits the edges best. Edges: from keyframes of a to keyframes of
  /// b, over the whole common area, by the ids and between the bases of their own maps.
  JoinResult result;
};

/// The map's name and fingerprint. Reads its keyframes and edges.
MatchedMap IdentityOf(const NamedMap& map);

/// Registers images of two maps with each other, drawn to a common view. Maps whose place
/// descriptors have nothing in common are not registered at all: no overlap, 0 comparisons.
/// No overlap, several possible poses and contradictions are results (JoinResult::verdict).
/// @param params  those of the odometry and the origin are not used.
/// @throws InputError when a map cannot be read, or the two have no common view.
MapMatch MatchMaps(const NamedMap& a, const NamedMap& b, const MapperParams& params = {});

/// T_a_b as edges from keyframes of a to keyframes of b measure it: the planar motion of least
/// squares of the positions, and of points at the distance `arm` ahead of them.
/// @param edges  at least one. @param T_a_from, T_b_to  poses of the keyframes on their maps, by
/// edge.
Pose2 RelativePose(const std::vector<graph::Edge>& edges,
                   const std::vector<Pose2>& T_a_from,
                   const std::vector<Pose2>& T_b_to,
                   double arm);

}  // namespace ceilmap::mapping
