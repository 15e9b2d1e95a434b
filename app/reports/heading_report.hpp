#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/evaluation/heading_errors.hpp"
#include "app/files/heading_csv.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/terminal/summary.hpp"
#include "calib/wheels/wheels_report.hpp"

namespace ceilmap::reports {

/// What wheels are compared with in `heading`, as for WheelWarnings.
constexpr const char* kPanoramas = "the panoramas";

/// Results of `heading`.
struct HeadingResult {
  std::vector<files::MeasuredHeading> headings;
  std::optional<evaluation::HeadingErrors> errors;  ///< with --truth
  std::int64_t frames = 0;                          ///< frames of the recording
  std::int64_t references = 0;
  std::int64_t held = 0;          ///< headings that the panorama did not determine
  std::int64_t levelled = 0;      ///< panoramas whose tilt was known
  std::int64_t contradicted = 0;  ///< panoramas that contradict the known turn
  wheels::WheelsReport wheels;    ///< and gyro
  cv::Size panorama;
  recordings::FrameSourceReport reading;
  double unwrap_ms = 0;
  double compass_ms = 0;
  double seconds = 0;
};

void Summarize(const HeadingResult& result, terminal::Summary& summary);
/// Prints the table of a run on stdout.
void PrintReport(const HeadingResult& result, const terminal::Summary& summary);

}  // namespace ceilmap::reports
