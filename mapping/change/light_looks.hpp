#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/change/change_evidence.hpp"
#include "mapping/change/change_regions.hpp"
#include "mapping/store/map_history.hpp"

namespace ceilmap::change {

/// The looks of a map in another light, after a recording. A recording in another light draws the
/// lamps as it saw them, and erases cells that look as the mosaic there. One in the light of the
/// map erases what it has renewed: how that looks in the other light is not known yet. There is one
/// look of a place, so that the map does not grow with the number of recordings.
/// @param looks  of the map. @param regions  FindChanges of the recording.
/// @param fresh  SessionOutcome::fresh. @param session  Its number.
std::vector<store::Look> UpdateLooks(std::vector<store::Look> looks,
                                     const ChangeEvidence& evidence,
                                     const std::vector<ChangedRegion>& regions,
                                     const std::vector<cv::Point>& fresh,
                                     std::int64_t session);

}  // namespace ceilmap::change
