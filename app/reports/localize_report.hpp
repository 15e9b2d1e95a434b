#pragma once

#include <cstdint>
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
#include "localization/localizer.hpp"

namespace ceilmap::reports {

/// Results of a localization run.
struct LocalizeResult {
  SensorResult sensors;
  localization::LocalizerReport report;
  recordings::FrameSourceReport reading;
  recordings::StampOrigin stamps = recordings::StampOrigin::kStampsFile;
  bool has_start = false;                ///< by --start
  std::optional<double> first_placed_s;  ///< after the first frame
  std::optional<std::int64_t> first_placed_frame;
  double path_m = 0;        ///< sum of distances between placed frames
  double mean_sigma_m = 0;  ///< of x and y, root mean square over the placed frames
  LatencyMeter latency;     ///< of the frames of a live source
  double seconds = 0;
  std::optional<double> bits_per_px;  ///< BitsPerPixel of the upward recording

  [[nodiscard]] std::int64_t Placed() const { return report.tracking + report.relocalized; }
};

Coverage CoverageOf(const LocalizeResult& result);

/// What was measured of the upward recording, for RecordingWarnings. @param source  Its name.
RecordingFacts RecordingFactsOf(const LocalizeResult& result, const std::string& source);

/// Frames, stages and quality for --summary.
void Summarize(const LocalizeResult& result, terminal::Summary& summary);

/// Prints the table of a run.
terminal::Table FactsOf(const LocalizeResult& result);

}  // namespace ceilmap::reports
