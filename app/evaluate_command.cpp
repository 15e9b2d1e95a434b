#include <fmt/format.h>

#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <system_error>

#include "app/arguments.hpp"
#include "app/commands.hpp"
#include "app/evaluation.hpp"
#include "app/output_files.hpp"
#include "app/table.hpp"
#include "app/tum.hpp"
#include "calib/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::app {
namespace {

using nlohmann::ordered_json;

const std::map<std::string, Alignment> kAlignments = {
    {"none", Alignment::kNone}, {"first", Alignment::kFirst}, {"se2", Alignment::kSe2}};

struct EvaluateParams {
  fs::path truth;
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

std::vector<Result> Evaluate(const EvaluateParams& params) {
  const std::vector<NamedFile> files = ParseEstimates(params.estimates);
  const std::vector<StampedPose> truth = ReadTum(params.truth);
  std::vector<Result> results;
  for (const NamedFile& file : files) {
    const auto errors = EvaluateTrajectory(truth, ReadTum(file.file), params.evaluation);
    if (!errors) {
      throw calib::InputError(fmt::format("{}: no pose within {} s of one of {}; see --max-dt",
                                          file.file.string(),
                                          params.evaluation.max_dt_s,
                                          params.truth.string()));
    }
    results.push_back({file.name, *errors});
  }
  return results;
}

ordered_json ToJson(const ErrorStatistics& statistics) {
  return {{"rmse", statistics.rmse},
          {"mean", statistics.mean},
          {"median", statistics.median},
          {"p95", statistics.p95},
          {"max", statistics.max}};
}

ordered_json ToJson(const TrajectoryErrors& errors, const std::string& align) {
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

void PrintReport(const std::vector<Result>& results) {
  Table coverage;
  coverage.AddRow({"estimate", "poses", "of", "coverage", "path m"});
  Table errors;
  errors.AddRow({"estimate", "error", "unit", "rmse", "mean", "median", "p95", "max"});
  for (const auto& [name, result] : results) {
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
}

void WriteReport(const fs::path& folder, const ordered_json& metrics, Summary& summary) {
  std::error_code error;
  const bool created = fs::create_directory(folder, error);
  if (error) {
    throw calib::RunError(
        fmt::format("{}: cannot be created ({})", folder.string(), error.message()));
  }
  try {
    WriteFileAtomically(folder / "metrics.json", metrics.dump(2) + "\n");
  } catch (...) {
    if (created) fs::remove(folder, error);
    throw;
  }
  summary.files.push_back(folder / "metrics.json");
}

void RunEvaluate(EvaluateParams params, Summary& summary) {
  RejectUnavailable(!params.map.empty(), "--map");
  params.evaluation.align = kAlignments.at(params.align);
  CheckReportFolder(params.report);
  const std::vector<Result> results = Evaluate(params);

  ordered_json metrics = {{"truth", params.truth.string()}};
  for (const Result& result : results) {
    metrics["estimates"][result.name] = ToJson(result.errors, params.align);
    summary.frames += result.errors.matched;
  }
  summary.quality = metrics;
  if (!params.report.empty()) WriteReport(params.report, metrics, summary);
  PrintReport(results);
}

}  // namespace

Command AddEvaluateCommand(CLI::App& program) {
  Command command = MakeCommand(program,
                                "evaluate",
                                "Compares estimated trajectories with the true one.",
                                "ceilmap evaluate --truth truth.tum mapped=lab.tum -o report");
  auto params = std::make_shared<EvaluateParams>();
  CLI::App& cli = *command.cli;
  cli.add_option("--truth", params->truth, "The true trajectory")->required()->type_name("T.tum");
  cli.add_option("estimates", params->estimates, "Trajectories to judge")
      ->required()
      ->type_name("[NAME=]EST.tum");
  cli.add_option("--map", params->map, "Picture under the paths (not in this version)")
      ->type_name("MAP.gpkg");
  cli.add_option("--align", params->align, "How estimates are brought into the truth's frame")
      ->check(CLI::IsMember({"none", "first", "se2"}))
      ->capture_default_str();
  cli.add_option("--max-dt", params->evaluation.max_dt_s, "Most seconds between compared poses")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S")
      ->capture_default_str();
  cli.add_option("-o,--output", params->report, "Folder for metrics.json, new or empty")
      ->type_name("REPORT_DIR");
  command.run = [params](const CommonOptions&, Summary& summary) { RunEvaluate(*params, summary); };
  return command;
}

}  // namespace ceilmap::app
