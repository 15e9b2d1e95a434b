#include "app/reports/map_report.hpp"

#include <fmt/format.h>

#include "app/reports/map_quality.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"

namespace ceilmap::reports {

void Summarize(const MapResult& result, const std::string& unit, terminal::Summary& summary) {
  const mapping::MapperReport& report = result.map.report;
  summary.frames = report.frames;
  summary.interrupted = terminal::Interrupted();
  summary.stages_ms = {{"decode", result.reading.decode_ms},
                       {"rectify", report.rectify_ms},
                       {"register", report.register_ms},
                       {"keyframe", report.keyframe_ms},
                       {"loops", report.loop_ms},
                       {"optimize", report.optimize_ms},
                       {"mosaic", report.mosaic_ms}};
  Summarize(CoverageOf(result), summary.quality);
  summary.quality.update({{"tracked", report.tracked},
                          {"lost", report.lost},
                          {"predicted", report.predicted},
                          {"ambiguous", report.ambiguous},
                          {"without_texture", report.without_texture},
                          {"missing", report.missing},
                          {"repeated", report.repeated},
                          {"coding_loss", report.coding_loss},
                          {"dropped", result.reading.dropped},
                          {"stream", StreamJson(result.reading, result.latency)},
                          {"unconnected", report.unconnected},
                          {"keyframes", report.keyframes},
                          {"loops", ToJson(report.quality.loops)},
                          {"chi2_per_dof", report.quality.chi2_per_dof},
                          {"loop_rms", report.quality.loop_rms},
                          {"weak_spots", ToJson(result.map.weak_spots)},
                          {"left_out", ToJson(report.left_out)},
                          {"median_peak", report.median_peak},
                          {"path", report.path},
                          {"map_width_px", report.grid.width_px},
                          {"map_height_px", report.grid.height_px},
                          {"map_resolution", report.grid.resolution},
                          {"unit", unit}});
  Summarize(result.sensors, summary);
}

Coverage CoverageOf(const MapResult& result) {
  return CoverageOf(result.map.report, result.stamps, result.sensors);
}

RecordingFacts RecordingFactsOf(const MapResult& result, const std::string& source) {
  const mapping::MapperReport& report = result.map.report;
  RecordingFacts facts;
  facts.source = source;
  facts.frames = report.frames;
  facts.missing = report.missing;
  facts.has_stamps = HasOwnStamps(result.stamps);
  facts.repeated = report.repeated;
  facts.coding_loss = report.coding_loss;
  facts.bits_per_px = result.bits_per_px;
  return facts;
}

void ReportCoverage(const MapResult& result,
                    const std::string& source,
                    terminal::Summary& summary) {
  const Coverage coverage = CoverageOf(result);
  summary.failure = CoverageFailure(coverage, source);
  const std::optional<std::string> warning = CoverageWarning(coverage);
  if (warning) terminal::PrintWarning(*warning);
  const std::int64_t frames = result.map.report.unconnected;
  if (frames == 0 || warning || !summary.failure.empty()) return;
  terminal::PrintWarning(fmt::format(
      "{} frames are left out: the robot was lost before them, and they are not connected to the "
      "rest; drive where the ceilings overlap, or map that part separately",
      frames));
}

terminal::Table FactsOf(const MapResult& result, const std::string& unit, double seconds) {
  const mapping::MapperReport& report = result.map.report;
  const double rate = seconds > 0 ? static_cast<double>(report.frames) / seconds : 0;
  const int decimals = unit == "m" ? 3 : 1;
  const store::MosaicGrid& grid = report.grid;
  terminal::Table table;
  table.AddRow({"on the map", ToString(CoverageOf(result))});
  table.AddRow({"lost",
                fmt::format("{}", report.lost),
                report.without_texture > 0
                    ? fmt::format("{} of them without texture", report.without_texture)
                    : ""});
  table.AddRow({"ambiguous", fmt::format("{}", report.ambiguous)});
  if (report.predicted > 0) {
    table.AddRow(
        {"predicted", fmt::format("{}", report.predicted), "of both, whose poses the wheels know"});
  }
  if (report.unconnected > 0) {
    table.AddRow({"unconnected",
                  fmt::format("{}", report.unconnected),
                  "of a part that is not connected to the map; left out"});
  }
  AddRows(result.sensors, table);
  table.AddRow({"keyframes", fmt::format("{}", report.keyframes)});
  table.AddRow({"loops closed",
                fmt::format("{}", report.quality.loops.accepted - report.quality.loops.outliers),
                fmt::format("of {} compared", report.quality.loops.compared)});
  if (!result.map.weak_spots.empty()) {
    table.AddRow({"weak spots",
                  fmt::format("{}", result.map.weak_spots.size()),
                  "'ceilmap info' names them"});
  }
  table.AddRow({"path", fmt::format("{:.{}f}", report.path, decimals), unit});
  table.AddRow({"map",
                fmt::format("{:.{}f} x {:.{}f}",
                            grid.width_px * grid.resolution,
                            decimals,
                            grid.height_px * grid.resolution,
                            decimals),
                unit});
  table.AddRow({"map", fmt::format("{} x {}", grid.width_px, grid.height_px), "px of the mosaic"});
  for (const store::LeftOut& place : report.left_out) {
    const std::string text = Describe({place}, unit);
    const std::size_t number = text.find(' ');
    table.AddRow({"left out", text.substr(0, number), text.substr(number + 1)});
  }
  AddStreamRows(result.reading, result.latency, table);
  table.AddRow({"time", fmt::format("{:.2f}", seconds), fmt::format("s ({:.1f} frames/s)", rate)});
  return table;
}

}  // namespace ceilmap::reports
