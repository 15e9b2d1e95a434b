#include "app/reports/localize_report.hpp"

#include <fmt/format.h>

#include "app/terminal/interrupt.hpp"

namespace ceilmap::reports {

Coverage CoverageOf(const LocalizeResult& result) {
  Coverage coverage = CoverageOf(result.report, result.stamps, result.sensors);
  coverage.has_start = result.has_start;
  return coverage;
}

void Summarize(const LocalizeResult& result, terminal::Summary& summary) {
  const localization::LocalizerReport& report = result.report;
  summary.frames = report.frames;
  summary.interrupted = terminal::Interrupted();
  summary.stages_ms = {{"decode", result.reading.decode_ms},
                       {"rectify", report.rectify_ms},
                       {"analyze", report.analyze_ms},
                       {"track", report.track_ms},
                       {"search", report.search_ms}};
  const auto or_null = [](const auto& value) {
    return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
  };
  Summarize(CoverageOf(result), summary.quality);
  summary.quality.update({{"tracking", report.tracking},
                          {"relocalized", report.relocalized},
                          {"predicted", report.predicted},
                          {"slips", report.slips},
                          {"ambiguous", report.ambiguous},
                          {"lost", report.lost},
                          {"dropped", result.reading.dropped},
                          {"searches", report.searches},
                          {"first_placed_frame", or_null(result.first_placed_frame)},
                          {"scale", or_null(report.scale)},
                          {"mean_sigma_m", result.mean_sigma_m},
                          {"path", result.path_m},
                          {"repeated", report.repeated},
                          {"coding_loss", report.coding_loss},
                          {"stream", StreamJson(result.reading, result.latency)}});
  Summarize(result.sensors, summary);
}

RecordingFacts RecordingFactsOf(const LocalizeResult& result, const std::string& source) {
  RecordingFacts facts;
  facts.source = source;
  facts.frames = result.report.frames;
  facts.has_stamps = HasOwnStamps(result.stamps);
  facts.repeated = result.report.repeated;
  facts.coding_loss = result.report.coding_loss;
  facts.bits_per_px = result.bits_per_px;
  return facts;
}

terminal::Table FactsOf(const LocalizeResult& result) {
  const localization::LocalizerReport& report = result.report;
  const auto frames = static_cast<double>(report.frames);
  const double rate = result.seconds > 0 ? frames / result.seconds : 0;
  const auto count = [](std::int64_t n) { return fmt::format("{}", n); };
  terminal::Table table;
  table.AddRow({"on the map", ToString(CoverageOf(result))});
  if (result.first_placed_s) {
    table.AddRow({"found", fmt::format("{:.2f}", *result.first_placed_s), "s after the start"});
  }
  if (report.relocalized > 1) {
    table.AddRow({"found again", count(report.relocalized - 1), "times after it was lost"});
  }
  if (report.predicted > 0) {
    table.AddRow({"predicted", count(report.predicted), "by the wheels alone"});
  }
  table.AddRow({"ambiguous", count(report.ambiguous)});
  table.AddRow({"lost", count(report.lost)});
  AddRows(result.sensors, table);
  if (report.scale) {
    table.AddRow({"scale",
                  fmt::format("{:.4f}", *report.scale),
                  "of the rig's heights and focal length relative to the map"});
  }
  table.AddRow({"path", fmt::format("{:.3f}", result.path_m), "m"});
  table.AddRow({"sigma", fmt::format("{:.2f}", 1e3 * result.mean_sigma_m), "mm, of x and y"});
  AddStreamRows(result.reading, result.latency, table);
  table.AddRow(
      {"time", fmt::format("{:.2f}", result.seconds), fmt::format("s ({:.1f} frames/s)", rate)});
  return table;
}

}  // namespace ceilmap::reports
