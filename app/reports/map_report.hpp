#pragma once

#include <string>
#include <vector>

#include "app/recordings/frame_source.hpp"
#include "app/reports/sensor_report.hpp"
#include "app/reports/stream_report.hpp"
#include "app/terminal/summary.hpp"
#include "app/terminal/table.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/mapper.hpp"

namespace ceilmap::reports {

/// Results of a mapping run.
struct MapResult {
  mapping::MappingResult map;
  SensorResult sensors;
  recordings::FrameSourceReport reading;
  LatencyMeter latency;  ///< of the frames of a live source, to their odometry pose
};

/// Frames, stages and quality for --summary. @param unit  of the map, "m" or "px".
void Summarize(const MapResult& result, const std::string& unit, terminal::Summary& summary);

/// Prints a warning when frames are left out of the map because they are not connected to it.
void WarnOfParts(const MapResult& result);

/// Prints the table of a run.
terminal::Table FactsOf(const MapResult& result, const std::string& unit, double seconds);

}  // namespace ceilmap::reports
