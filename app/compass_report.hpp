#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "app/compass_frames.hpp"
#include "app/evaluation/heading_errors.hpp"
#include "app/frame_source.hpp"
#include "app/heading_csv.hpp"
#include "app/summary.hpp"
#include "app/table.hpp"
#include "localization/compass/colour/colour_model.hpp"

namespace ceilmap::app {

/// What a run over a recording did to a model: `compass learn` and `compass update`.
struct CompassLearnResult {
  std::int64_t frames = 0;  ///< of the recording
  std::int64_t used = 0;
  UnusedFrames unused;
  FrameSourceReport reading;
  double learn_ms = 0;
  double seconds = 0;
};

void Summarize(const CompassLearnResult& result,
               const colour::ColourModel& model,
               Summary& summary);
void PrintReport(const CompassLearnResult& result,
                 const colour::ColourModel& model,
                 const Summary& summary);

/// What `compass query` did.
struct CompassQueryResult {
  /// As FormatHeadings and HeadingFigure take them: counter-clockwise from the x axis of the
  /// learned poses.
  std::vector<MeasuredHeading> headings;
  std::optional<evaluation::HeadingErrors> errors;  ///< with --truth, absolute
  std::int64_t frames = 0;                          ///< of the recording
  UnusedFrames unused;
  std::int64_t without_turn = 0;  ///< turn since the frame before not seen
  std::int64_t learned = 0;       ///< with --update
  FrameSourceReport reading;
  double compass_ms = 0;
  double seconds = 0;

  [[nodiscard]] double MeanSigmaRad() const;
};

/// Confidence from which on a heading is believed to be the only one.
inline constexpr double kSureConfidence = 0.9;

void Summarize(const CompassQueryResult& result, Summary& summary);
void PrintReport(const CompassQueryResult& result, const Summary& summary);

/// What a model holds, for tables and summaries.
void AddModelRows(const colour::ColourModel& model, Table& table);
nlohmann::ordered_json ModelJson(const colour::ColourModel& model);

}  // namespace ceilmap::app
