#include "app/reports/compass_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/reports/evaluation_json.hpp"
#include "app/terminal/interrupt.hpp"
#include "calib/base/degrees.hpp"

namespace ceilmap::reports {
namespace {
constexpr double kSmallErrorRad = 0.1;

// Fraction of small errors, with the limit of the publications.
double PartBelow(const evaluation::HeadingErrors& errors, double limit_rad) {
  const auto small = [limit_rad](const evaluation::HeadingError& error) {
    return std::abs(error.error_deg) < kDegPerRad * limit_rad;
  };
  return static_cast<double>(std::count_if(errors.of.begin(), errors.of.end(), small)) /
         static_cast<double>(errors.of.size());
}

void AddQueryErrors(const evaluation::HeadingErrors& errors, terminal::Table& table) {
  const auto add = [&table](const char* name, double error_deg) {
    table.AddRow({name,
                  fmt::format("{:.4f}", error_deg / kDegPerRad),
                  fmt::format("rad, {:.3f} deg", error_deg)});
  };
  table.AddRow({"true path", fmt::format("{:.3f}", errors.path_m), "m"});
  table.AddRow({"true turns", fmt::format("{:.3f}", errors.turned_deg), "deg"});
  add("mean error", errors.error_deg.mean);
  add("rms error", errors.error_deg.rmse);
  add("max error", errors.error_deg.max);
  table.AddRow({"small errors",
                fmt::format("{:.1f}", 100 * PartBelow(errors, kSmallErrorRad)),
                fmt::format("% below {} rad", kSmallErrorRad)});
}

void AddUnused(const recordings::UnusedFrames& unused, terminal::Table& table) {
  if (unused.without_pose > 0) {
    table.AddRow(
        {"no pose", fmt::to_string(unused.without_pose), "frames without a pose at their time"});
  }
  if (unused.below_horizon > 0) {
    table.AddRow({"skipped",
                  fmt::to_string(unused.below_horizon),
                  "frames with too few pixels above the horizon"});
  }
}

void AddTimes(
    const char* what, double work_ms, std::int64_t frames, double seconds, terminal::Table& table) {
  const auto count = static_cast<double>(std::max<std::int64_t>(frames, 1));
  table.AddRow({what, fmt::format("{:.3f}", work_ms / count), "ms a frame"});
  const double rate = seconds > 0 ? static_cast<double>(frames) / seconds : 0;
  table.AddRow({"time", fmt::format("{:.2f}", seconds), fmt::format("s ({:.1f} frames/s)", rate)});
}

void Print(const terminal::Table& table, const terminal::Summary& summary) {
  fmt::print("{}", table.Format());
  for (const auto& file : summary.files) fmt::print("written {}\n", file.string());
}

// Summary of a model's content.
struct Content {
  std::int64_t cells = 0;  // cells with content
  std::int64_t bins = 0;
  double filled = 0;  // fraction of the bins of these cells
};

Content ContentOf(const colour::ColourModel& model) {
  Content content;
  for (const colour::Cell& cell : model.cells) {
    if (cell.empty()) continue;
    ++content.cells;
    content.bins += std::count_if(
        cell.bins.begin(), cell.bins.end(), [](const auto& bin) { return !bin.empty(); });
  }
  if (content.cells > 0) {
    content.filled = static_cast<double>(content.bins) /
                     (static_cast<double>(content.cells) * static_cast<double>(model.bins));
  }
  return content;
}

}  // namespace

void AddModelRows(const colour::ColourModel& model, terminal::Table& table) {
  const Content content = ContentOf(model);
  table.AddRow({"classes", fmt::format("{}", model.classes.size()), "of colours"});
  table.AddRow(
      {"cells", fmt::to_string(content.cells), fmt::format("of {} seen from", model.cells.size())});
  table.AddRow({"directions",
                fmt::format("{:.1f}", 100 * content.filled),
                fmt::format("% of {} in each of these", model.bins)});
  table.AddRow({"depth", fmt::format("{:.2f}", model.depth_m), "m to the surroundings"});
}

nlohmann::ordered_json ModelJson(const colour::ColourModel& model) {
  const Content content = ContentOf(model);
  return {{"kind", ToString(model.kind)},
          {"classes", model.classes.size()},
          {"cells", model.cells.size()},
          {"cells_seen", content.cells},
          {"bins", model.bins},
          {"bins_filled", content.bins},
          {"filled", content.filled},
          {"depth_m", model.depth_m},
          {"frames", model.frames}};
}

void Summarize(const CompassLearnResult& result,
               const colour::ColourModel& model,
               terminal::Summary& summary) {
  summary.frames = result.frames;
  summary.interrupted = terminal::Interrupted();
  summary.stages_ms = {{"decode", result.reading.decode_ms}, {"learn", result.learn_ms}};
  summary.quality = {{"used", result.used},
                     {"without_pose", result.unused.without_pose},
                     {"below_horizon", result.unused.below_horizon},
                     {"dropped", result.reading.dropped},
                     {"model", ModelJson(model)}};
}

void PrintReport(const CompassLearnResult& result,
                 const colour::ColourModel& model,
                 const terminal::Summary& summary) {
  terminal::Table table;
  table.AddRow({"frames", fmt::to_string(result.frames)});
  table.AddRow({"learned", fmt::to_string(result.used)});
  AddUnused(result.unused, table);
  AddModelRows(model, table);
  AddTimes("learning", result.learn_ms, result.frames, result.seconds, table);
  Print(table, summary);
}

double CompassQueryResult::MeanSigmaRad() const {
  double sum = 0;
  for (const files::MeasuredHeading& heading : headings) {
    sum += std::sqrt(heading.estimate.variance_rad2);
  }
  return headings.empty() ? 0 : sum / static_cast<double>(headings.size());
}

void Summarize(const CompassQueryResult& result, terminal::Summary& summary) {
  summary.frames = result.frames;
  summary.interrupted = terminal::Interrupted();
  summary.stages_ms = {{"decode", result.reading.decode_ms}, {"compass", result.compass_ms}};
  const auto ambiguous = std::count_if(
      result.headings.begin(), result.headings.end(), [](const files::MeasuredHeading& heading) {
        return heading.estimate.confidence < kUniqueConfidence;
      });
  summary.quality = {
      {"headings", result.headings.size()},
      {"without_pose", result.unused.without_pose},
      {"below_horizon", result.unused.below_horizon},
      {"without_turn", result.without_turn},
      {"unsure", ambiguous},
      {"learned", result.learned},
      {"dropped", result.reading.dropped},
      {"mean_sigma_deg", kDegPerRad * result.MeanSigmaRad()},
      {"compass_ms_per_frame",
       result.compass_ms / static_cast<double>(std::max<std::int64_t>(result.frames, 1))}};
  if (result.gains) summary.quality["gains_bgr"] = *result.gains;
  if (!result.errors) return;
  nlohmann::ordered_json errors = ToJson(*result.errors);
  errors["mean_rad"] = result.errors->error_deg.mean / kDegPerRad;
  errors["rmse_rad"] = result.errors->error_deg.rmse / kDegPerRad;
  errors["max_rad"] = result.errors->error_deg.max / kDegPerRad;
  errors["below_0_1_rad"] = PartBelow(*result.errors, kSmallErrorRad);
  summary.quality["errors"] = std::move(errors);
}

void PrintReport(const CompassQueryResult& result, const terminal::Summary& summary) {
  terminal::Table table;
  table.AddRow({"frames", fmt::to_string(result.frames)});
  table.AddRow({"headings", fmt::to_string(static_cast<std::int64_t>(result.headings.size()))});
  AddUnused(result.unused, table);
  if (const auto ambiguous = summary.quality["unsure"].get<std::int64_t>(); ambiguous > 0) {
    table.AddRow({"unsure", fmt::to_string(ambiguous), "headings: others match too"});
  }
  if (result.learned > 0) {
    table.AddRow({"learned", fmt::to_string(result.learned), "frames during the run"});
  }
  if (result.reading.dropped > 0) {
    table.AddRow({"dropped", fmt::to_string(result.reading.dropped), "frames of a live source"});
  }
  if (result.gains) {
    const colour::ChannelGains& gains = *result.gains;
    table.AddRow({"white balance",
                  fmt::format("{:.3f} {:.3f} {:.3f}", gains[0], gains[1], gains[2]),
                  "gains of blue, green, red"});
  }
  const compass::HeadingEstimate& last = result.headings.back().estimate;
  table.AddRow(
      {"heading",
       fmt::format("{:.2f}", kDegPerRad * last.heading_rad),
       fmt::format("deg at the end, sigma {:.2f}", kDegPerRad * std::sqrt(last.variance_rad2))});
  table.AddRow({"sigma", fmt::format("{:.2f}", kDegPerRad * result.MeanSigmaRad()), "deg, mean"});
  if (result.errors) AddQueryErrors(*result.errors, table);
  AddTimes("compass", result.compass_ms, result.frames, result.seconds, table);
  Print(table, summary);
}

}  // namespace ceilmap::reports
