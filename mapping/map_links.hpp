#pragma once

#include <cstddef>
#include <vector>

#include "calib/base/pose2.hpp"
#include "mapping/graph/keyframe.hpp"

/// Choice of the pairs of maps that fit together. Internal.
namespace ceilmap::mapping {

/// A piece of one map as another map sees it: one edge between them.
struct LinkSample {
  Pose2 T_a_here;  ///< pose of the keyframe of b on map a, by the edge
  Pose2 T_b_here;  ///< its pose on map b
};

/// Two maps that were joined by themselves.
struct MapLink {
  std::size_t a = 0;
  std::size_t b = 0;
  std::size_t edges = 0;  ///< their number: the weight of the link
  Pose2 T_a_b;
  std::vector<LinkSample> samples;  ///< some edges, spread over all, at least one
};

/// What is known of a map.
struct LinkedMap {
  std::size_t keyframes = 0;
  double extent = 0;  ///< diagonal of the keyframes' bounding box, map units
};

/// Maps that links connect, with poses that follow from a spanning tree of the heaviest links.
struct MapGroup {
  std::vector<std::size_t> maps;   ///< in increasing order
  std::vector<std::size_t> links;  ///< all links between them that agree, in increasing order
  std::vector<Pose2> T_first_map;  ///< by position in `maps`, relative to the first of them
};

struct LinkChoice {
  /// The group with the most keyframes; of equal ones, that with the lowest map.
  MapGroup group;
  std::vector<std::size_t> contradicting;  ///< links that do not fit the others
};

/// Chooses the links that agree with each other. Where a cycle of links does not close, the link is
/// removed without which most edges agree. A cycle closes when it ends within half a span, and one
/// per cent of the extent of its maps: maps are slightly bent. Smaller contradictions are left to
/// the robust optimization of all keyframes.
/// @param excluded  links that are not used. @param span  map units across an image, > 0.
LinkChoice ChooseLinks(const std::vector<LinkedMap>& maps,
                       const std::vector<MapLink>& links,
                       const std::vector<std::size_t>& excluded,
                       double span);

}  // namespace ceilmap::mapping
