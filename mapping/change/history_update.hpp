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
  int confirmed = 0;          ///< changes that the map shows from now on
  int candidates = 0;         ///< that wait for another session
  double seen_area = 0;       ///< map units^2
  double changed_area = 0;    ///< confirmed in this session
  double candidate_area = 0;  ///< seen otherwise for the first time
};

/// Decides by the evidence of this recording and of those before it. What looks otherwise is a
/// candidate. Where the next session in the light of the map sees it too, it is confirmed and the
/// map is renewed; where that session sees what the map shows, it is forgotten: sun patches,
/// shadows and what was parked below the ceiling do not stay. A session in another light confirms
/// nothing; its lamps are listed once.
/// @param session  of this recording; id and areas are set here.
/// @param at_once  Confirm what a single session sees, in any light.
SessionOutcome DecideChanges(const ChangeEvidence& evidence,
                             const std::vector<ChangedRegion>& regions,
                             const store::MosaicGrid& grid,
                             store::MapHistory history,
                             store::Session session,
                             bool at_once = false);

}  // namespace ceilmap::change
