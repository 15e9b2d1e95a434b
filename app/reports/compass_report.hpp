#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "app/evaluation/heading_errors.hpp"
#include "app/files/heading_csv.hpp"
#include "app/recordings/compass_frames.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/terminal/summary.hpp"
#include "app/terminal/table.hpp"
#include "localization/compass/colour/colour_model.hpp"
#include "localization/compass/colour/white_balance.hpp"

namespace ceilmap::reports {

/// Changes of a model by a recording: `compass learn` and `compass update`.
struct CompassLearnResult {
  std::int64_t frames = 0;  ///< frames of the recording
  std::int64_t used = 0;
  recordings::UnusedFrames unused;
  recordings::FrameSourceReport reading;
  double learn_ms = 0;
  double seconds = 0;
};

void Summarize(const CompassLearnResult& result,
               const colour::ColourModel& model,
               terminal::Summary& summary);
void PrintReport(const CompassLearnResult& result,
                 const colour::ColourModel& model,
                 const terminal::Summary& summary);

/// Results of `compass query`.
struct CompassQueryResult {
  /// For FormatHeadings and HeadingFigure: counter-clockwise from the x axis of the learned poses.
  std::vector<files::MeasuredHeading> headings;
  std::optional<evaluation::HeadingErrors> errors;  ///< with --truth, absolute
  std::int64_t frames = 0;                          ///< frames of the recording
  recordings::UnusedFrames unused;
  std::int64_t without_turn = 0;              ///< turn since the previous frame not measured
  std::int64_t learned = 0;                   ///< with --update
  std::optional<colour::ChannelGains> gains;  ///< with --white-balance
  recordings::FrameSourceReport reading;
  double compass_ms = 0;
  double seconds = 0;

  [[nodiscard]] double MeanSigmaRad() const;
};

/// Confidence above which a heading is accepted as unique.
inline constexpr double kUniqueConfidence = 0.9;

void Summarize(const CompassQueryResult& result, terminal::Summary& summary);
void PrintReport(const CompassQueryResult& result, const terminal::Summary& summary);

/// Content of a model, for tables and summaries.
void AddModelRows(const colour::ColourModel& model, terminal::Table& table);
nlohmann::ordered_json ModelJson(const colour::ColourModel& model);

}  // namespace ceilmap::reports
