#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <optional>

#include "app/commands/commands.hpp"
#include "app/commands/localize_files.hpp"
#include "app/commands/localize_run.hpp"
#include "app/commands/new_ground.hpp"
#include "app/commands/size_budget.hpp"
#include "app/files/output_files.hpp"
#include "app/reports/history_report.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/error.hpp"
#include "calib/base/result_date.hpp"
#include "calib/level_view.hpp"
#include "localization/robot/map_updater.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct UpdateOptions {
  LocalizeInputs inputs;
  fs::path output;
  fs::path trajectory;
  robot::MapUpdaterOptions updater;
  SizeBudget budget;
  bool no_new_ground = false;

  [[nodiscard]] fs::path Result() const { return output.empty() ? inputs.map : output; }
  void Check(files::Existing existing) const;
};

void UpdateOptions::Check(files::Existing existing) const {
  inputs.Check();
  const fs::path rig_out = inputs.sensors.wheels.rig_out;
  inputs.CheckOutputs({trajectory, rig_out});
  // Without --output the map itself is changed.
  files::CheckOutputFiles(
      {Result(), trajectory, rig_out}, existing, output.empty() ? inputs.map : fs::path());
}

/// Adds what lies beyond the map. The renewed map is complete without it, so that a failure is no
/// error.
std::optional<std::int64_t> AddGround(const UpdateOptions& options,
                                      const CommonOptions& common,
                                      const robot::MapUpdateReport& report) {
  if (!report.left_map || options.no_new_ground) return std::nullopt;
  const auto warn = [](const std::string& why) {
    terminal::PrintWarning("the robot left the map, and that ground was not added: " + why);
  };
  if (report.session.other_light) {
    warn("the recording was made in another light than the map");
  } else if (!CanBeReadAgain(options.inputs.up)) {
    warn("a live camera cannot be read twice; record it, and use 'ceilmap map --append'");
  } else {
    try {
      return AddNewGround(options.inputs, options.Result(), common.command_line);
    } catch (const InputError& error) {
      warn(error.what());
    } catch (const RunError& error) {
      warn(error.what());
    }
  }
  return std::nullopt;
}

void RunUpdate(UpdateOptions options, const CommonOptions& common, terminal::Summary& summary) {
  LocalizeInputs& inputs = options.inputs;
  inputs.sensors.TakeBag(inputs.bags, inputs.up);
  options.Check(common.Existing());
  options.updater.max_bytes = options.budget.Bytes();
  auto updater = std::make_unique<robot::MapUpdater>(
      inputs.map, options.Result(), common.command_line, options.updater);
  LocalizeRun run(inputs, std::nullopt, summary);
  LocalizeOutputs outputs;
  outputs.trajectory = options.trajectory;
  LocalizeFiles poses(outputs, calib::LevelView(run.Localizer().View()));
  run.Locate([&](const robot::Estimate& estimate) {
    poses.Add(estimate);
    updater->Add(estimate);
  });
  const reports::LocalizeResult result = run.Result();
  run.PrintSourceWarnings(result);
  if (result.Placed() == 0) run.ReportNothingFound(result);
  store::Session session;
  session.date = ResultDate();
  session.source = fs::path(inputs.up).filename().string();
  session.robot = run.Rig().robot;
  session.program_version = CEILMAP_VERSION;
  const robot::MapUpdateReport report = updater->Finish(session);
  updater.reset();  // releases the map's name
  const std::optional<std::int64_t> new_keyframes = AddGround(options, common, report);
  if (report.retirement && !report.retirement->within_budget) {
    terminal::PrintWarning(options.Result().string() +
                           " is larger than the budget: no more keyframes can be spared");
  }
  summary.files.push_back(options.Result());
  if (!options.trajectory.empty()) poses.Commit(summary);
  inputs.sensors.wheels.WriteRig(run.Rig(), result.sensors.report.wheels, summary);
  run.PrintWarnings(result);
  reports::Summarize(result, summary);
  summary.quality["update"] = reports::ToJson(report);
  if (new_keyframes) summary.quality["update"]["new_keyframes"] = *new_keyframes;
  if (common.quiet) return;
  terminal::Table facts = reports::FactsOf(report);
  if (new_keyframes) facts.AddRow({"new ground", fmt::format("{} keyframes", *new_keyframes)});
  fmt::print("{}", facts.Format(terminal::Table::Numbers::kLeft));
  for (const fs::path& file : summary.files) fmt::print("written {}\n", file.string());
}

}  // namespace

Command AddUpdateCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "update",
      "Renews a map where the ceiling has changed, and extends it, by the recording of a "
      "robot that drives on it; its frame does not move.",
      "ceilmap update hall.gpkg --rig rig.yaml --up up.mp4 --stamps frames.csv\n"
      "  ceilmap update hall.gpkg --up monday.mcap --up-topic /up/image_raw -o "
      "monday.gpkg\n"
      "'ceilmap info --changes MAP' lists what has changed.");
  auto options = std::make_shared<UpdateOptions>();
  CLI::App& cli = *command.cli;
  options->inputs.AddTo(cli, "the map");
  cli.remove_option(cli.get_option("--uncompensated"));  // a result of `localize`
  cli.add_option("-o,--output", options->output, "The renewed map [the map itself]")
      ->type_name("NEW.gpkg")
      ->group(LocalizeInputs::kResult);
  cli.add_option("--trajectory", options->trajectory, "Poses of all frames found; T.mcap: a bag")
      ->type_name("T.tum")
      ->group(LocalizeInputs::kResult);
  cli.add_flag("--at-once",
               options->updater.at_once,
               "Renew the map by this recording alone; otherwise a second one must confirm a "
               "change, because sun patches and parked things do not stay")
      ->group(LocalizeInputs::kResult);
  cli.add_flag("--no-new-ground",
               options->no_new_ground,
               "Do not add what lies beyond the map, for which the recording is read again")
      ->group(LocalizeInputs::kResult);
  options->budget.AddTo(cli,
                        "Then retire keyframes that others cover until the file is not larger, as "
                        "'ceilmap prune' does",
                        LocalizeInputs::kResult);
  command.run = [options](const CommonOptions& common, terminal::Summary& summary) {
    RunUpdate(*options, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
