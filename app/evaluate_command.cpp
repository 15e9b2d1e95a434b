#include <fmt/format.h>

#include <cmath>
#include <map>
#include <memory>

#include "app/arguments.hpp"
#include "app/commands.hpp"
#include "app/comparison.hpp"
#include "app/comparison_report.hpp"
#include "app/csv.hpp"
#include "app/report_folder.hpp"
#include "calib/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::app {
namespace {

using evaluation::Alignment;

const std::map<std::string, Alignment> kAlignments = {{"none", Alignment::kNone},
                                                      {"first", Alignment::kFirst},
                                                      {"se2", Alignment::kSe2},
                                                      {"sim2", Alignment::kSim2}};

struct EvaluateParams {
  ComparisonParams comparison;
  fs::path map;
  std::string align = "se2";
  std::string offset;
  std::string segments = "1,2,5,10";
  fs::path report;
};

ClockOffset ParseOffset(const std::string& text) {
  if (text.empty()) return {};
  if (text == "auto") return {.search = true};
  ClockOffset offset;
  if (!ParseNumber(text, offset.seconds) || !std::isfinite(offset.seconds)) {
    throw calib::InputError(fmt::format("--offset {}: must be seconds, or auto", text));
  }
  return offset;
}

void PrintReport(const Comparison& comparison) {
  std::string text;
  for (const ReportTable& table : ComparisonTables(comparison)) {
    if (!text.empty()) text += '\n';
    text += FormatPlain(table);
  }
  fmt::print("{}", text);
}

void RunEvaluate(EvaluateParams params, const CommonOptions& common, Summary& summary) {
  RejectUnavailable(!params.map.empty(), "--map");
  evaluation::EvaluationParams& evaluation = params.comparison.evaluation;
  evaluation.align = kAlignments.at(params.align);
  if (!params.comparison.frame_from.empty()) params.align = "frame-from";
  evaluation.segments.lengths_m = ParsePositiveNumbers(params.segments, "--segments");
  params.comparison.offset = ParseOffset(params.offset);
  if (!params.report.empty()) CheckReportFolder(params.report);

  const Comparison comparison = Compare(params.comparison);
  for (const ComparedEstimate& estimate : comparison.estimates) {
    summary.frames += estimate.matched;
  }
  summary.quality = ComparisonJson(comparison, params.comparison, params.align);
  if (!params.report.empty()) {
    summary.files = WriteReport(params.report, ReportFiles(comparison, summary.quality));
  }
  if (!common.quiet) PrintReport(comparison);
}

}  // namespace

Command AddEvaluateCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "evaluate",
      "Compares estimated trajectories with the true one.",
      "ceilmap evaluate --truth truth.tum mapped=lab.tum -o report\n"
      "  ceilmap evaluate --truth truth.tum live=live.tum status.csv heading.csv -o report\n"
      "  ceilmap evaluate --truth truth.tum other-clock.tum --offset auto --align sim2\n"
      "  ceilmap evaluate --truth truth.tum --before uncompensated.tum fused=compensated.tum -o "
      "table\n"
      "  ceilmap evaluate --truth second.tum --frame-from map-truth.tum map.tum status.csv\n"
      "An estimate is a trajectory (TUM), a status file of localize, or headings (CSV).");
  auto params = std::make_shared<EvaluateParams>();
  ComparisonParams& comparison = params->comparison;
  CLI::App& cli = *command.cli;
  cli.add_option("--truth", comparison.truth, "The true trajectory")
      ->required()
      ->type_name("T.tum");
  cli.add_option("estimates", comparison.estimates, "What to judge: trajectories, status, headings")
      ->required()
      ->type_name("[NAME=]EST");
  cli.add_option(
         "--before",
         comparison.before,
         "Without tilt compensation; tells what it is worth: largest errors before and after")
      ->type_name("T0.tum");
  cli.add_option("--map", params->map, "Picture under the paths (not in this version)")
      ->type_name("MAP.gpkg");
  CLI::Option* const align =
      cli.add_option("--align",
                     params->align,
                     "How estimates are brought into the truth's frame, --before aside")
          ->check(CLI::IsMember({"none", "first", "se2", "sim2"}))
          ->capture_default_str();
  cli.add_option("--frame-from",
                 comparison.frame_from,
                 "Instead: truth and estimate of the run that made the map the robots were on")
      ->expected(2)
      ->allow_extra_args(false)
      ->type_name("T.tum EST.tum")
      ->excludes(align);
  cli.add_option("--max-dt", comparison.evaluation.max_dt_s, "Most seconds between compared poses")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S")
      ->capture_default_str();
  cli.add_option("--offset",
                 params->offset,
                 "Added to the stamps of estimates; auto: found from how the robot moved")
      ->type_name("S|auto");
  cli.add_option("--expect",
                 comparison.expect,
                 "Frames that there should be poses for, instead of the truth's stamps")
      ->type_name("FRAMES.csv");
  cli.add_option("--segments",
                 params->segments,
                 "Metres of the way over which errors of the motion are told")
      ->type_name("M,M,...")
      ->capture_default_str();
  cli.add_option("-o,--output",
                 params->report,
                 "Folder for metrics.json, CSV files, and tables in Markdown and LaTeX; new or "
                 "empty")
      ->type_name("REPORT_DIR");
  command.run = [params](const CommonOptions& common, Summary& summary) {
    RunEvaluate(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::app
