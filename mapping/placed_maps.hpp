#pragma once

#include <vector>

#include "mapping/common_view.hpp"
#include "mapping/graph/keyframe.hpp"

namespace ceilmap::mapping {

/// The keyframes of a map on another map of the same ceiling.
struct PlacedKeyframes {
  /// Of b, by id, without heights: poses on a.
  std::vector<graph::Keyframe> keyframes;
  /// The maps have keyframes in common, with the same poses: b is an updated or pruned copy of a,
  /// or a of b.
  bool same_frame = false;
  Pose2 T_a_b;    ///< of same_frame: identity
  int edges = 0;  ///< measured between the maps; of same_frame: 0
};

/// Places the keyframes of b on a. Maps of other recordings are matched (MatchMaps); each keyframe
/// is then placed by the measurements nearest to it, because two maps bend in other ways.
/// @throws InputError as MatchMaps; RunError with the reason when the maps do not join.
PlacedKeyframes PlacedOn(const NamedMap& a, const NamedMap& b);

}  // namespace ceilmap::mapping
