#pragma once

#include <vector>

#include "mapping/change/change_evidence.hpp"
#include "mapping/change/change_regions.hpp"
#include "mapping/store/map_history.hpp"

namespace ceilmap::change {

/// What a recording means for a map.
struct SessionOutcome {
  store::MapHistory history;  ///< with the session and its changes
  /// Cells whose look in the recording the map is to show from now on.
  std::vector<cv::Point> fresh;
  int confirmed = 0;        ///< changes that the map shows from now on
  int candidates = 0;       ///< that wait for another session
  double seen_area = 0;     ///< map units^2
  double changed_area = 0;  ///< confirmed in this session
};

/// Decides by the evidence of this recording and of those before it:
/// - another texture, and a lamp that is off while most are on, are confirmed at once: images from
///   several places agree on them;
/// - another brightness alone is a candidate, and confirmed when a later session sees it at the
///   same place: sun patches and shadows do not stay;
/// - a candidate that a later session sees as the map shows it is forgotten.
/// @param session  of this recording; id and areas are set here.
SessionOutcome DecideChanges(const ChangeEvidence& evidence,
                             const std::vector<ChangedRegion>& regions,
                             const store::MosaicGrid& grid,
                             store::MapHistory history,
                             store::Session session);

}  // namespace ceilmap::change
