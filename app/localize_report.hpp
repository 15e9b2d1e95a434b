#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/frame_source.hpp"
#include "app/heading_meter.hpp"
#include "app/summary.hpp"
#include "app/table.hpp"
#include "app/tilt_meter.hpp"
#include "localization/localizer.hpp"

namespace ceilmap::app {

/// What a localization run found.
struct LocalizeResult {
  const TiltMeter* tilt = nullptr;        ///< null: tilt was not measured
  const HeadingMeter* heading = nullptr;  ///< null: there were none
  localization::LocalizerReport report;
  FrameSourceReport reading;
  std::optional<double> first_placed_s;  ///< after the first frame
  std::optional<std::int64_t> first_placed_frame;
  double path_m = 0;        ///< between placed frames
  double mean_sigma_m = 0;  ///< of x and y, root mean square over the placed frames
  /// From a live frame's arrival to its pose, the longest one; unset for recordings.
  std::optional<double> latency_ms;
  double seconds = 0;

  [[nodiscard]] std::int64_t Placed() const { return report.tracking + report.relocalized; }
};

/// Frames, stages and quality for --summary.
void Summarize(const LocalizeResult& result, Summary& summary);

/// The table that ends a run.
Table FactsOf(const LocalizeResult& result);

}  // namespace ceilmap::app
