#pragma once

#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/store/map_history.hpp"

namespace ceilmap::mapping {

/// The history of a map, and its keyframes as they were in it.
struct PartHistory {
  store::MapHistory history;
  std::vector<graph::Keyframe> keyframes;  ///< ids and bases are those of the union
};

/// The history of a map of which others are parts, or which was optimized again. Each change moves
/// with the keyframe next to it; of a keyframe that has not moved it stays to the last bit.
/// Sessions and changes get new numbers: sessions by their dates, those of one part in their order;
/// a single part keeps its numbers.
/// @param united  its keyframes, in its frame. Changes of parts of which it has no keyframe are
/// left out; looks too, because the mosaic is drawn anew (MoveLooks).
store::MapHistory UniteHistories(std::vector<PartHistory> parts, const graph::MapGraph& united);

/// A mosaic, and the keyframes of which it was drawn.
struct DrawnMap {
  const store::MosaicGrid& grid;
  const std::vector<graph::Keyframe>& keyframes;
};
/// Looks in another light over a mosaic that was drawn anew: each moves with the keyframe next to
/// it, as changes do.
/// @return by id, in tiles of the new mosaic.
std::vector<store::Look> MoveLooks(const std::vector<store::Look>& looks,
                                   const DrawnMap& before,
                                   const DrawnMap& after);

}  // namespace ceilmap::mapping
