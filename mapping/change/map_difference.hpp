#pragma once

#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/store/map_history.hpp"

namespace ceilmap::change {

/// What differs between two maps of one ceiling.
struct MapDifference {
  /// In the frame of the first map: kind, difference, area and polygons. No sessions and frames: a
  /// comparison has none.
  std::vector<store::Change> changes;
  double compared_area = 0;  ///< of the first map's mosaic, map units^2
  double changed_area = 0;   ///< of that, without Kind::kLight
  /// Whether most of the lamps that one map shows as lit are off in the other.
  bool other_light = false;
};

/// Compares the mosaics of two maps, as an update compares images with a mosaic
/// (mapping/change/README.md): windows of the later one, each place in four of them, are the
/// images. About 10 ms for each 160,000 pixels on one core.
/// @param before, after  with mosaics.
/// @param keyframes  all of `after`, by id, placed on `before` (mapping::PlacedOn): a window lies
/// where the keyframe next to it does.
/// @param threads  0: as many as the machine has cores.
/// @throws InputError as MapReader, and for a map without a mosaic.
MapDifference CompareMaps(const store::MapReader& before,
                          const store::MapReader& after,
                          const std::vector<graph::Keyframe>& keyframes,
                          int threads = 0);

}  // namespace ceilmap::change
