#pragma once

#include <string>
#include <vector>

#include "app/frame_source.hpp"
#include "app/heading_meter.hpp"
#include "app/summary.hpp"
#include "app/table.hpp"
#include "app/tilt_meter.hpp"
#include "mapping/map_graph.hpp"
#include "mapping/mapper.hpp"

namespace ceilmap::app {

/// What a mapping run made.
struct MapResult {
  const TiltMeter* tilt = nullptr;         ///< null: tilt was not measured
  const HeadingMeter* heading = nullptr;   ///< null: there were none
  std::vector<mapping::FramePose> frames;  ///< of this recording
  mapping::MapperReport report;
  std::vector<mapping::WeakSpot> weak_spots;  ///< of the whole map
};

/// Frames, stages and quality for --summary. @param unit  of the map, "m" or "px".
void Summarize(const MapResult& result,
               const FrameSourceReport& reading,
               const std::string& unit,
               Summary& summary);

/// A warning on stderr when frames are not in the map because nothing ties them to it.
void WarnOfParts(const MapResult& result);

/// The table that ends a run.
Table FactsOf(const MapResult& result, const std::string& unit, double seconds);

}  // namespace ceilmap::app
