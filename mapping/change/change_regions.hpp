#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/change/change_evidence.hpp"
#include "mapping/store/map_history.hpp"

namespace ceilmap::change {

/// A connected part of the ceiling that one recording saw changed.
struct ChangedRegion {
  store::Change::Kind kind = store::Change::Kind::kSurface;
  std::vector<cv::Point> cells;  ///< of the map
  std::int64_t frames = 0;  ///< images that showed a cell of it changed, largest number of a cell
  double difference = 0;    ///< mean of CellDifference::share
};

/// The changed regions of a recording. Single cells, and lines one cell wide, are none: the border
/// of a sun patch or of a shadow is no change of the ceiling. In another light
/// (ChangeEvidence::OtherLight) lamps are Kind::kLight, and brightness alone tells nothing.
std::vector<ChangedRegion> FindChanges(const ChangeEvidence& evidence);

/// Cells, and those of their neighbours that are not clearly the same: a border within a cell
/// leaves it unclear. Of all of them a look is known that two images agree on.
std::vector<cv::Point> FreshCells(const ChangeEvidence& evidence,
                                  const std::vector<cv::Point>& cells);

/// The outline of cells, in the map.
store::Polygons OutlineOf(const std::vector<cv::Point>& cells, const store::MosaicGrid& grid);

/// The cells of which at least half lies in polygons.
std::vector<cv::Point> CellsIn(const store::Polygons& polygons, const store::MosaicGrid& grid);

}  // namespace ceilmap::change
