#include <fmt/format.h>

#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <system_error>

#include "app/arguments.hpp"
#include "app/commands.hpp"
#include "app/compensation_report.hpp"
#include "app/evaluation/compensation.hpp"
#include "app/evaluation/trajectory_errors.hpp"
#include "app/output_files.hpp"
#include "app/table.hpp"
#include "app/tum.hpp"
#include "calib/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::app {
namespace {

using evaluation::Alignment;
using evaluation::CompensationParams;
using evaluation::ErrorStatistics;
using evaluation::EvaluationParams;
using evaluation::LevelAlignment;
using evaluation::TiltDegrees;
using evaluation::TrajectoryErrors;
using nlohmann::ordered_json;

const std::map<std::string, Alignment> kAlignments = {
    {"none", Alignment::kNone}, {"first", Alignment::kFirst}, {"se2", Alignment::kSe2}};

struct EvaluateParams {
  fs::path truth;
  fs::path before;  // empty: no table of a compensation
  std::vector<std::string> estimates;
  fs::path map;
  std::string align = "se2";
  EvaluationParams evaluation;
  fs::path report;
};

struct Result {
  std::string name;
  TrajectoryErrors errors;
};

// What tilt compensation is worth.
struct BeforeAndAfter {
  LevelAlignment alignment;
  TiltDegrees largest_true_tilt;
  std::vector<NamedCompensation> estimates;
};

struct Evaluation {
  std::vector<Result> results;
  std::optional<BeforeAndAfter> compensation;
};

struct ReportFile {
  std::string name;
  std::string text;
};

// The report must not mix with what is in the folder already.
void CheckReportFolder(const fs::path& folder) {
  std::error_code ignored;
  if (folder.empty()) return;
  if (fs::is_directory(folder, ignored) && fs::is_empty(folder, ignored)) return;
  if (fs::exists(folder, ignored)) {
    throw calib::InputError(
        fmt::format("{}: exists and is not an empty folder; name a new one", folder.string()));
  }
  const fs::path name = folder.has_filename() ? folder : folder.parent_path();
  CheckOutputFiles({name});
}

std::vector<NamedFile> ParseEstimates(const std::vector<std::string>& arguments) {
  std::vector<NamedFile> files;
  std::set<std::string> names;
  for (const std::string& argument : arguments) {
    files.push_back(ParseNamedFile(argument));
    if (!names.insert(files.back().name).second) {
      throw calib::InputError(fmt::format(
          "{}: the name '{}' is taken; write NAME={}", argument, files.back().name, argument));
    }
  }
  return files;
}

[[noreturn]] void ThrowNothingInCommon(const fs::path& file, const EvaluateParams& params) {
  throw calib::InputError(fmt::format("{}: no pose within {} s of one of {}; see --max-dt",
                                      file.string(),
                                      params.evaluation.max_dt_s,
                                      params.truth.string()));
}

BeforeAndAfter AlignBefore(const std::vector<StampedPose>& truth,
                           const std::vector<StampedPose>& before,
                           const CompensationParams& compensation,
                           const EvaluateParams& params) {
  const LevelAlignment alignment = AlignLevelFrames(truth, before, compensation);
  if (alignment.matched == 0) ThrowNothingInCommon(params.before, params);
  if (!alignment.T_truth_before) {
    throw calib::InputError(
        fmt::format("{}: {} of its {} compared frames level by {} (pitch and roll below {} deg), "
                    "must be at least 2 to align on",
                    params.before.string(),
                    alignment.level,
                    alignment.matched,
                    params.truth.string(),
                    compensation.level_below_deg));
  }
  return {alignment, LargestTilt(truth), {}};
}

Evaluation Evaluate(const EvaluateParams& params) {
  const std::vector<NamedFile> files = ParseEstimates(params.estimates);
  const std::vector<StampedPose> truth = ReadTum(params.truth);
  const CompensationParams compensation{.max_dt_s = params.evaluation.max_dt_s};
  Evaluation evaluation;
  std::vector<StampedPose> before;
  if (!params.before.empty()) {
    before = ReadTum(params.before);
    evaluation.compensation = AlignBefore(truth, before, compensation, params);
  }
  for (const NamedFile& file : files) {
    const std::vector<StampedPose> estimate = ReadTum(file.file);
    const auto errors = EvaluateTrajectory(truth, estimate, params.evaluation);
    if (!errors) ThrowNothingInCommon(file.file, params);
    evaluation.results.push_back({file.name, *errors});
    if (!evaluation.compensation) continue;
    const calib::Pose2& T_truth_before = *evaluation.compensation->alignment.T_truth_before;
    auto compared = CompareCompensation(truth, before, estimate, T_truth_before, compensation);
    if (!compared) ThrowNothingInCommon(file.file, params);
    evaluation.compensation->estimates.push_back({file.name, std::move(*compared)});
  }
  return evaluation;
}

ordered_json ErrorsToJson(const TrajectoryErrors& errors, const std::string& align) {
  ordered_json json = {{"matched", errors.matched},
                       {"expected", errors.expected},
                       {"coverage", errors.Coverage()},
                       {"path_m", errors.path_m},
                       {"align", align},
                       {"position_m", ToJson(errors.position_m)},
                       {"yaw_deg", ToJson(errors.yaw_deg)}};
  if (errors.per_metre_m) json["per_metre_m"] = ToJson(*errors.per_metre_m);
  if (errors.per_metre_yaw_deg) json["per_metre_yaw_deg"] = ToJson(*errors.per_metre_yaw_deg);
  return json;
}

void AddRow(Table& table,
            const std::string& name,
            const std::string& what,
            const std::string& unit,
            const std::optional<ErrorStatistics>& statistics) {
  if (!statistics) return;
  std::vector<std::string> cells = {name, what, unit};
  for (const double value :
       {statistics->rmse, statistics->mean, statistics->median, statistics->p95, statistics->max}) {
    cells.push_back(fmt::format("{:.5f}", value));
  }
  table.AddRow(std::move(cells));
}

ordered_json Metrics(const Evaluation& evaluation, const EvaluateParams& params) {
  ordered_json metrics = {{"truth", params.truth.string()}};
  for (const Result& result : evaluation.results) {
    metrics["estimates"][result.name] = ErrorsToJson(result.errors, params.align);
  }
  if (!evaluation.compensation) return metrics;
  const auto& [alignment, largest_true_tilt, estimates] = *evaluation.compensation;
  for (const auto& [name, compensation] : estimates) {
    metrics["estimates"][name]["compensation"] = ToJson(compensation);
  }
  metrics["before"] = ToJson(estimates.front().compensation.before);
  metrics["before"]["file"] = params.before.string();
  metrics["before"]["level_frames"] = alignment.level;
  metrics["true_tilt_deg"] = {{"pitch_max", largest_true_tilt.pitch_deg},
                              {"roll_max", largest_true_tilt.roll_deg}};
  return metrics;
}

std::vector<ReportFile> ReportFiles(const Evaluation& evaluation, const ordered_json& metrics) {
  std::vector<ReportFile> files = {{"metrics.json", metrics.dump(2) + "\n"}};
  if (!evaluation.compensation) return files;
  const std::vector<NamedCompensation>& estimates = evaluation.compensation->estimates;
  files.push_back({"compensation.csv", FormatTableCsv(estimates)});
  for (const auto& [name, compensation] : estimates) {
    files.push_back({name + "-errors.csv", FormatFramesCsv(compensation)});
  }
  return files;
}

void PrintReport(const Evaluation& evaluation) {
  Table coverage;
  coverage.AddRow({"estimate", "poses", "of", "coverage", "path m"});
  Table errors;
  errors.AddRow({"estimate", "error", "unit", "rmse", "mean", "median", "p95", "max"});
  for (const auto& [name, result] : evaluation.results) {
    coverage.AddRow({name,
                     fmt::format("{}", result.matched),
                     fmt::format("{}", result.expected),
                     fmt::format("{:.4f}", result.Coverage()),
                     fmt::format("{:.3f}", result.path_m)});
    AddRow(errors, name, "position", "m", result.position_m);
    AddRow(errors, name, "yaw", "deg", result.yaw_deg);
    AddRow(errors, name, "position per metre", "m", result.per_metre_m);
    AddRow(errors, name, "yaw per metre", "deg", result.per_metre_yaw_deg);
  }
  fmt::print("{}\n{}", coverage.Format(), errors.Format());
  if (evaluation.compensation) {
    fmt::print("\n{}", FormatTables(evaluation.compensation->estimates));
  }
}

// All files of the report or none of them.
void WriteReport(const fs::path& folder,
                 const std::vector<ReportFile>& files,
                 std::vector<fs::path>& written) {
  std::error_code error;
  const bool created = fs::create_directory(folder, error);
  if (error) {
    throw calib::RunError(
        fmt::format("{}: cannot be created ({})", folder.string(), error.message()));
  }
  std::vector<fs::path> done;
  try {
    for (const ReportFile& file : files) {
      WriteFileAtomically(folder / file.name, file.text);
      done.push_back(folder / file.name);
    }
  } catch (...) {
    for (const fs::path& file : done) fs::remove(file, error);
    if (created) fs::remove(folder, error);
    throw;
  }
  written.insert(written.end(), done.begin(), done.end());
}

void RunEvaluate(EvaluateParams params, Summary& summary) {
  RejectUnavailable(!params.map.empty(), "--map");
  params.evaluation.align = kAlignments.at(params.align);
  CheckReportFolder(params.report);
  const Evaluation evaluation = Evaluate(params);

  for (const Result& result : evaluation.results) summary.frames += result.errors.matched;
  summary.quality = Metrics(evaluation, params);
  if (!params.report.empty()) {
    WriteReport(params.report, ReportFiles(evaluation, summary.quality), summary.files);
  }
  PrintReport(evaluation);
}

}  // namespace

Command AddEvaluateCommand(CLI::App& program) {
  Command command = MakeCommand(program,
                                "evaluate",
                                "Compares estimated trajectories with the true one.",
                                "ceilmap evaluate --truth truth.tum mapped=lab.tum -o report\n"
                                "  ceilmap evaluate --truth truth.tum --before uncompensated.tum "
                                "fused=compensated.tum -o table");
  auto params = std::make_shared<EvaluateParams>();
  CLI::App& cli = *command.cli;
  cli.add_option("--truth", params->truth, "The true trajectory")->required()->type_name("T.tum");
  cli.add_option("estimates", params->estimates, "Trajectories to judge")
      ->required()
      ->type_name("[NAME=]EST.tum");
  cli.add_option(
         "--before",
         params->before,
         "Without tilt compensation; tells what it is worth: largest errors before and after")
      ->type_name("T0.tum");
  cli.add_option("--map", params->map, "Picture under the paths (not in this version)")
      ->type_name("MAP.gpkg");
  cli.add_option("--align",
                 params->align,
                 "How estimates are brought into the truth's frame, --before aside")
      ->check(CLI::IsMember({"none", "first", "se2"}))
      ->capture_default_str();
  cli.add_option("--max-dt", params->evaluation.max_dt_s, "Most seconds between compared poses")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S")
      ->capture_default_str();
  cli.add_option("-o,--output",
                 params->report,
                 "Folder for metrics.json and, with --before, CSV files; new or empty")
      ->type_name("REPORT_DIR");
  command.run = [params](const CommonOptions&, Summary& summary) { RunEvaluate(*params, summary); };
  return command;
}

}  // namespace ceilmap::app
