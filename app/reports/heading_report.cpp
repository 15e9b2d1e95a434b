#include "app/reports/heading_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "app/reports/evaluation_json.hpp"
#include "app/reports/wheel_report.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/table.hpp"
#include "calib/base/degrees.hpp"

namespace ceilmap::reports {
namespace {

void AddHeadingErrors(const evaluation::HeadingErrors& errors, terminal::Table& table) {
  const auto number = [](double value) { return fmt::format("{:.3f}", value); };
  table.AddRow({"true path", number(errors.path_m), "m"});
  table.AddRow({"true turns", number(errors.turned_deg), "deg"});
  table.AddRow({"max error", number(errors.error_deg.max), "deg"});
  table.AddRow({"rms error", number(errors.error_deg.rmse), "deg"});
  table.AddRow({"mean error", number(errors.signed_mean_deg), "deg, signed"});
  table.AddRow({"std of errors", number(errors.std_deg), "deg"});
  table.AddRow({"end error", number(errors.end_deg), "deg"});
  if (errors.drift_deg_per_m) {
    table.AddRow({"drift", number(*errors.drift_deg_per_m), "deg/m"});
  }
  if (errors.drift_deg_per_s) {
    table.AddRow({"drift", number(*errors.drift_deg_per_s), "deg/s"});
  }
}

}  // namespace

void Summarize(const HeadingResult& result, terminal::Summary& summary) {
  summary.frames = result.frames;
  summary.interrupted = terminal::Interrupted();
  summary.stages_ms = {{"decode", result.reading.decode_ms},
                       {"unwrap", result.unwrap_ms},
                       {"compass", result.compass_ms}};
  const compass::HeadingEstimate& last = result.headings.back().estimate;
  summary.quality = {{"headings", result.headings.size()},
                     {"references", result.references},
                     {"untold", result.held},
                     {"dropped", result.reading.dropped},
                     {"columns", result.panorama.width},
                     {"rows", result.panorama.height},
                     {"end_heading_deg", kDegPerRad * last.heading_rad},
                     {"end_sigma_deg", kDegPerRad * std::sqrt(last.variance_rad2)}};
  if (result.wheels.samples > 0 || result.wheels.gyro) {
    summary.quality["contradicted"] = result.contradicted;
    summary.quality["wheels"] = WheelQuality(result.wheels);
  }
  if (result.errors) summary.quality["errors"] = ToJson(*result.errors);
}

void PrintReport(const HeadingResult& result, const terminal::Summary& summary) {
  const auto frames = static_cast<double>(result.frames);
  const compass::HeadingEstimate& last = result.headings.back().estimate;
  const auto count = [](std::int64_t n) { return fmt::format("{}", n); };
  const auto milliseconds = [&](double total) { return fmt::format("{:.3f}", total / frames); };
  terminal::Table table;
  table.AddRow({"frames", count(result.frames)});
  table.AddRow({"headings", count(static_cast<std::int64_t>(result.headings.size()))});
  if (result.held > 0) table.AddRow({"held", count(result.held), "not determined by the panorama"});
  if (result.contradicted > 0) {
    table.AddRow({"contradicted", count(result.contradicted), "by wheels or gyro, not used"});
  }
  if (result.reading.dropped > 0) {
    table.AddRow({"dropped", count(result.reading.dropped), "frames of a live source"});
  }
  table.AddRow({"panorama",
                count(result.panorama.width),
                fmt::format("x {} columns and rows", result.panorama.height)});
  table.AddRow({"references", count(result.references)});
  table.AddRow(
      {"heading",
       fmt::format("{:.2f}", kDegPerRad * last.heading_rad),
       fmt::format("deg at the end, sigma {:.2f}", kDegPerRad * std::sqrt(last.variance_rad2))});
  AddWheelRows(result.wheels, kPanoramas, table);
  if (result.errors) AddHeadingErrors(*result.errors, table);
  table.AddRow({"unwrap", milliseconds(result.unwrap_ms), "ms a frame"});
  table.AddRow({"compass", milliseconds(result.compass_ms), "ms a frame"});
  const double rate = result.seconds > 0 ? frames / result.seconds : 0;
  table.AddRow(
      {"time", fmt::format("{:.2f}", result.seconds), fmt::format("s ({:.1f} frames/s)", rate)});
  fmt::print("{}", table.Format());
  for (const auto& file : summary.files) fmt::print("written {}\n", file.string());
}

}  // namespace ceilmap::reports
