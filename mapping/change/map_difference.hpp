#pragma once

#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/store/map_history.hpp"

namespace ceilmap::change {

/// What differs between two maps of one ceiling.
struct MapDifference {
  /// In the frame of the first map: kind, frames (keyframes of the second map that show it),
  /// difference, area and polygons. No sessions: a comparison has none.
  std::vector<store::Change> changes;
  int views = 0;             ///< keyframes of the second map that were compared
  double compared_area = 0;  ///< of the first map's mosaic, map units^2
  double changed_area = 0;   ///< of that, without Kind::kLight
  /// Whether most of the lamps that one map shows as lit are off in the other.
  bool other_light = false;
};

/// Compares the images of the keyframes of a later map with the mosaic of an earlier one, as an
/// update does with those of a recording (mapping/change/README.md). A single keyframe tells of a
/// change: it was chosen for the map. About 10 ms for each keyframe on one core.
/// @param before  with a mosaic. @param after  the other map.
/// @param keyframes  of `after`, placed on `before` (mapping::PlacedOn).
/// @param threads  0: as many as the machine has cores.
/// @throws InputError as MapReader, and for a map without a mosaic.
MapDifference CompareMaps(const store::MapReader& before,
                          const store::MapReader& after,
                          const std::vector<graph::Keyframe>& keyframes,
                          int threads = 0);

}  // namespace ceilmap::change
