#pragma once

#include <string>
#include <vector>

#include "app/recordings/frame_source.hpp"
#include "app/reports/sensor_report.hpp"
#include "app/terminal/summary.hpp"
#include "app/terminal/table.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/mapper.hpp"

namespace ceilmap::reports {

/// What a mapping run made.
struct MapResult {
  mapping::MappingResult map;
  SensorResult sensors;
};

/// Frames, stages and quality for --summary. @param unit  of the map, "m" or "px".
void Summarize(const MapResult& result,
               const recordings::FrameSourceReport& reading,
               const std::string& unit,
               terminal::Summary& summary);

/// A warning on stderr when frames are not in the map because nothing ties them to it.
void WarnOfParts(const MapResult& result);

/// The table that ends a run.
terminal::Table FactsOf(const MapResult& result, const std::string& unit, double seconds);

}  // namespace ceilmap::reports
