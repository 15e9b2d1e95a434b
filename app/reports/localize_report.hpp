#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/recordings/frame_source.hpp"
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
  std::optional<double> first_placed_s;  ///< after the first frame
  std::optional<std::int64_t> first_placed_frame;
  double path_m = 0;        ///< sum of distances between placed frames
  double mean_sigma_m = 0;  ///< of x and y, root mean square over the placed frames
  LatencyMeter latency;     ///< of the frames of a live source
  double seconds = 0;

  [[nodiscard]] std::int64_t Placed() const { return report.tracking + report.relocalized; }
};

/// Frames, stages and quality for --summary.
void Summarize(const LocalizeResult& result, terminal::Summary& summary);

/// Prints the table of a run.
terminal::Table FactsOf(const LocalizeResult& result);

}  // namespace ceilmap::reports
