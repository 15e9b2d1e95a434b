#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/recordings/frame_source.hpp"
#include "app/reports/coverage.hpp"
#include "app/reports/recording_checks.hpp"
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
  recordings::FrameSourceReport reading;
  recordings::StampOrigin stamps = recordings::StampOrigin::kStampsFile;
  SensorResult sensors;
  LatencyMeter latency;               ///< of the frames of a live source, to their odometry pose
  std::optional<double> bits_per_px;  ///< BitsPerPixel of the upward recording
};
Coverage CoverageOf(const MapResult& result);

/// Frames, stages and quality for --summary. @param unit  of the map, "m" or "px".
void Summarize(const MapResult& result, const std::string& unit, terminal::Summary& summary);

/// What was measured of the upward recording, for RecordingWarnings. @param source  Its name.
RecordingFacts RecordingFactsOf(const MapResult& result, const std::string& source);

/// Of frames that are not on the map: prints CoverageWarning, or a warning when frames are not
/// connected to the map; sets summary.failure (CoverageFailure).
/// @param source  Name of the recording.
void ReportCoverage(const MapResult& result, const std::string& source, terminal::Summary& summary);

/// Prints the table of a run.
terminal::Table FactsOf(const MapResult& result, const std::string& unit, double seconds);

}  // namespace ceilmap::reports
