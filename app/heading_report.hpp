#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/evaluation/heading_errors.hpp"
#include "app/frame_source.hpp"
#include "app/heading_csv.hpp"
#include "app/summary.hpp"

namespace ceilmap::app {

/// What `heading` did.
struct HeadingResult {
  std::vector<MeasuredHeading> headings;
  std::optional<evaluation::HeadingErrors> errors;  ///< with --truth
  std::int64_t frames = 0;                          ///< of the recording
  std::int64_t references = 0;
  std::int64_t untold = 0;  ///< headings of confidence 0
  cv::Size panorama;
  FrameSourceReport reading;
  double unwrap_ms = 0;
  double compass_ms = 0;
  double seconds = 0;
};

void Summarize(const HeadingResult& result, Summary& summary);
/// The table of a run, on stdout.
void PrintReport(const HeadingResult& result, const Summary& summary);

}  // namespace ceilmap::app
