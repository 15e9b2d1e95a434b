#include <fmt/format.h>

#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "app/commands/commands.hpp"
#include "app/commands/frame_option.hpp"
#include "app/commands/plan_option.hpp"
#include "app/files/arguments.hpp"
#include "app/files/csv.hpp"
#include "app/files/output_files.hpp"
#include "app/page/page.hpp"
#include "app/reports/comparison.hpp"
#include "app/reports/comparison_figures.hpp"
#include "app/reports/comparison_page.hpp"
#include "app/reports/comparison_report.hpp"
#include "app/reports/comparison_tables.hpp"
#include "app/reports/page_parts.hpp"
#include "app/reports/report_folder.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/error.hpp"
#include "mapping/store/map_file.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using evaluation::Alignment;

const std::map<std::string, Alignment> kAlignments = {{"none", Alignment::kNone},
                                                      {"first", Alignment::kFirst},
                                                      {"se2", Alignment::kSe2},
                                                      {"sim2", Alignment::kSim2}};

struct EvaluateOptions {
  reports::ComparisonInputs comparison;
  fs::path map;
  FrameOption frame;  // of the first estimate
  PlanOption plan;
  std::string align = "se2";
  std::string offset;
  std::string segments = "1,2,5,10";
  fs::path report;
};

reports::ClockOffset ParseOffset(const std::string& text) {
  if (text.empty()) return {};
  if (text == "auto") return {.search = true};
  reports::ClockOffset offset;
  if (!files::ParseNumber(text, offset.seconds) || !std::isfinite(offset.seconds)) {
    throw InputError(fmt::format("--offset {}: must be seconds, or auto", text));
  }
  return offset;
}

// The map below the paths. The page is in its frame or in that of the building, figures in its own.
struct ShownMap {
  explicit ShownMap(const EvaluateOptions& params)
      : map(params.map), site(params.plan.Site(map, params.frame.Value())) {
    if (!site) return;
    const Similarity2& S_site_map = site->frame.S_site_map;
    const bool run_in_site = params.frame.Value() == store::Frame::kSite;
    (run_in_site ? S_map_run : S_page_run) = run_in_site ? S_site_map.Inverse() : S_site_map;
  }

  store::MapReader map;
  std::optional<reports::PageSite> site;  // of the page
  Similarity2 S_map_run;                  // from the frame of the first estimate
  Similarity2 S_page_run;
};

// With a map, all paths are shown in the frame of the first estimate, or in one that is known from
// it.
reports::ShownFrame ShownOn(const ShownMap* map) {
  return map != nullptr ? reports::ShownFrame::kFirstRun : reports::ShownFrame::kTruth;
}

void PrintReport(const reports::Comparison& comparison) {
  std::string text;
  for (const reports::ReportTable& table : reports::ComparisonTables(comparison)) {
    if (!text.empty()) text += '\n';
    text += reports::FormatPlain(table);
  }
  fmt::print("{}", text);
}

// Paths of the estimates with positions, over the mosaic of a map if there is one.
void DrawFigures(const reports::Comparison& comparison,
                 const ShownMap* map,
                 const fs::path& folder,
                 terminal::Summary& summary) {
  std::vector<reports::ComparedRun> runs;
  for (const reports::ComparedEstimate& estimate : comparison.estimates) {
    if (estimate.errors) runs.push_back({estimate.file.name, &*estimate.errors});
  }
  if (runs.empty()) return;
  const Similarity2 T_shown_truth =
      reports::T_shown_truth(runs, ShownOn(map), map != nullptr ? map->S_map_run : Similarity2());
  figures::TrajectoryComparison shown =
      reports::ComparisonFor(comparison.truth, runs, T_shown_truth);
  if (comparison.compensation) {
    shown.before = reports::FigurePosesBefore(
        comparison.truth, comparison.compensation->estimates.front().compensation, T_shown_truth);
  }
  reports::DrawTrajectoryFigures(
      std::move(shown), map != nullptr ? &map->map : nullptr, folder, summary);
}

reports::ReportFile PageFile(const reports::Comparison& comparison,
                             const ShownMap* map,
                             const EvaluateOptions& params) {
  const bool in_map = map != nullptr && !map->site;
  const std::string unit = in_map ? map->map.Metadata().unit : "m";
  page::PageData data = reports::ComparisonPage(comparison,
                                                reports::ComparisonTables(comparison),
                                                ShownOn(map),
                                                unit,
                                                map != nullptr ? map->S_page_run : Similarity2());
  data.note = fmt::format("Truth: {}; aligned: {}", params.comparison.truth.string(), params.align);
  if (map != nullptr) reports::AddMap(map->map, map->site, data);
  return {"index.html", page::WritePage(data)};
}

void RunEvaluate(EvaluateOptions params, const CommonOptions& common, terminal::Summary& summary) {
  if (!params.map.empty() && params.report.empty()) {
    throw InputError("--map: its mosaic is the background of a report's figures; give -o too");
  }
  evaluation::EvaluationParams& evaluation = params.comparison.evaluation;
  evaluation.align = kAlignments.at(params.align);
  if (!params.comparison.frame_from.empty()) params.align = "frame-from";
  evaluation.segments.lengths_m = files::ParsePositiveNumbers(params.segments, "--segments");
  params.comparison.offset = ParseOffset(params.offset);
  if (!params.report.empty()) files::CheckOutputFolder(params.report, common.Existing());
  std::optional<ShownMap> map;
  if (!params.map.empty()) map.emplace(params);

  const reports::Comparison comparison = reports::Compare(params.comparison);
  for (const reports::ComparedEstimate& estimate : comparison.estimates) {
    summary.frames += estimate.matched;
  }
  summary.quality = reports::ComparisonJson(comparison, params.comparison, params.align);
  if (!params.report.empty()) {
    const ShownMap* const under = map ? &*map : nullptr;
    std::vector<reports::ReportFile> files = {PageFile(comparison, under, params)};
    for (reports::ReportFile& file : reports::ReportFiles(comparison, summary.quality)) {
      files.push_back(std::move(file));
    }
    summary.files = reports::WriteReport(params.report, files);
    DrawFigures(comparison, under, params.report / "figures", summary);
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
      "  ceilmap evaluate --truth truth.tum robot.tum --map lab.gpkg --plan lab.dxf -o report\n"
      "An estimate is a trajectory (TUM, or a bag with poses), a status file of localize, or "
      "headings (CSV).");
  auto params = std::make_shared<EvaluateOptions>();
  reports::ComparisonInputs& comparison = params->comparison;
  CLI::App& cli = *command.cli;
  cli.add_option("--truth", comparison.truth, "The true trajectory")
      ->required()
      ->type_name("T.tum");
  cli.add_option(
         "estimates", comparison.estimates, "Estimates: trajectories, status files, headings")
      ->required()
      ->type_name("[NAME=]EST");
  cli.add_option(
         "--before",
         comparison.before,
         "The trajectory without tilt compensation, for the largest errors before and after")
      ->type_name("T0.tum");
  cli.add_flag("--before-own-run",
               comparison.before_is_another_run,
               "T0 is of another run, with a map of its own ('map --tilt none'): it and each "
               "estimate are aligned by their own level parts")
      ->needs("--before");
  CLI::Option* const map =
      cli.add_option("--map",
                     params->map,
                     "Map of the first estimate: its mosaic is the background of the paths")
          ->type_name("MAP.gpkg");
  params->frame.AddTo(cli)->needs(map)->description(
      "Coordinates of the estimates, and of the page: of the map, or of the building "
      "(localize --frame site)");
  params->plan.AddTo(cli)->needs(map);
  CLI::Option* const align =
      cli.add_option(
             "--align", params->align, "Alignment of estimates with the truth, except --before")
          ->check(CLI::IsMember({"none", "first", "se2", "sim2"}))
          ->capture_default_str();
  cli.add_option("--frame-from",
                 comparison.frame_from,
                 "Instead: truth and estimate of the run that made the robots' map")
      ->expected(2)
      ->allow_extra_args(false)
      ->type_name("T.tum EST.tum")
      ->excludes(align);
  cli.add_option(
         "--max-dt", comparison.evaluation.max_dt_s, "Maximum time between compared poses, seconds")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S")
      ->capture_default_str();
  cli.add_option("--offset",
                 params->offset,
                 "Added to the stamps of estimates; auto: found from the robot's motion")
      ->type_name("S|auto");
  cli.add_option(
         "--expect", comparison.expect, "Frames with expected poses, instead of the truth's stamps")
      ->type_name("FRAMES.csv");
  cli.add_option("--segments",
                 params->segments,
                 "Distances in metres over which errors of the motion are reported")
      ->type_name("M,M,...")
      ->capture_default_str();
  cli.add_option("-o,--output",
                 params->report,
                 "Folder for a page (index.html), metrics.json, CSV files, tables in Markdown and "
                 "LaTeX, and figures")
      ->type_name("REPORT_DIR");
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunEvaluate(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
