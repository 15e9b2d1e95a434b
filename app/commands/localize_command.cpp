#include <fmt/format.h>

#include <optional>
#include <utility>

#include "app/commands/commands.hpp"
#include "app/commands/frame_option.hpp"
#include "app/commands/localize_files.hpp"
#include "app/commands/localize_run.hpp"
#include "app/commands/plan_option.hpp"
#include "app/files/output_files.hpp"
#include "app/live/run_watch.hpp"
#include "app/reports/localize_report.hpp"
#include "app/reports/page_parts.hpp"
#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"
#include "calib/rig.hpp"
#include "localization/robot/ceiling_localizer.hpp"
#include "mapping/store/map_file.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct LocalizeOptions {
  LocalizeInputs inputs;
  fs::path output;
  fs::path status;
  fs::path hypotheses;
  bool stream = false;
  bool predicted = false;
  FrameOption frame;
  PlanOption plan;
  live::WatchOptions watch;

  // Checks everything that can be checked without the recording. @throws InputError
  void Check(files::Existing existing) const;
  [[nodiscard]] LocalizeOutputs Outputs(const std::optional<survey::SiteFrame>& site) const {
    return {output, inputs.sensors.uncompensated, status, hypotheses, predicted, stream, site};
  }
  // The building's coordinates for --frame site. @throws InputError when the map has none.
  [[nodiscard]] std::optional<survey::SiteFrame> Site() const;
};

void LocalizeOptions::Check(files::Existing existing) const {
  inputs.Check();
  const SensorOptions& sensors = inputs.sensors;
  if (predicted && sensors.wheels.odometry.empty()) {
    throw InputError("--predicted: poses are predicted by wheels; give --odometry");
  }
  if (frame.Value() == store::Frame::kSite &&
      (files::IsBagName(output) || files::IsBagName(sensors.uncompensated))) {
    throw InputError("--frame site: bags are in the map's coordinates; give T.tum as the output");
  }
  const std::vector<fs::path> outputs = {
      output, sensors.uncompensated, status, hypotheses, sensors.wheels.rig_out};
  inputs.CheckOutputs(outputs);
  plan.CheckHasPage(watch.HasPage());
  files::CheckOutputFiles(outputs, existing);
  watch.Check(existing);
}

std::optional<survey::SiteFrame> LocalizeOptions::Site() const {
  if (frame.Value() == store::Frame::kMap) return std::nullopt;
  return *store::SiteOf(store::MapReader(inputs.map), frame.Value());
}

// Initial content of the live page: the map.
page::PageData StartOfPage(const LocalizeOptions& params,
                           const store::MapReader& map,
                           const std::optional<reports::PageSite>& site) {
  page::PageData page;
  page.title =
      fmt::format("{} on {}",
                  fs::path(params.inputs.up).filename().string(),
                  fs::path(WithoutSecrets(params.inputs.map.string())).filename().string());
  if (params.watch.Live()) reports::AddMap(map, site, page);
  return page;
}

void RunLocalize(LocalizeOptions params, const CommonOptions& common, terminal::Summary& summary) {
  LocalizeInputs& inputs = params.inputs;
  inputs.sensors.TakeBag(inputs.bags, inputs.up);
  params.Check(common.Existing());
  const std::optional<survey::SiteFrame> site = params.Site();
  std::optional<reports::PageSite> page_site;
  if (params.watch.HasPage()) {
    page_site = params.plan.Site(store::MapReader(inputs.map), params.frame.Value());
  }
  LocalizeRun run(inputs, site, summary);
  const robot::CeilingLocalizer& localizer = run.Localizer();
  const store::MapReader& map = localizer.Map();

  LocalizeFiles results(params.Outputs(site), calib::LevelView(localizer.View()));
  page::PageData page = StartOfPage(params, map, page_site);
  live::RunWatch watch(params.watch, inputs.up, std::move(page), localizer.View(), page_site);
  run.Locate([&](const robot::Estimate& estimate) {
    results.Add(estimate);
    watch.Add(robot::ToFramePose(estimate), run.ExpectedFrames());
  });
  const reports::LocalizeResult result = run.Result();
  run.PrintSourceWarnings(result);
  if (result.Placed() == 0) {
    results.CommitStatus();  // the file shows the reason
    run.ReportNothingFound(result);
  }
  results.Commit(summary);
  inputs.sensors.wheels.WriteRig(run.Rig(), result.sensors.report.wheels, summary);
  run.PrintWarnings(result);
  summary.failure = reports::CoverageFailure(reports::CoverageOf(result), inputs.up);
  reports::Summarize(result, summary);
  const terminal::Table facts = reports::FactsOf(result);
  const bool quiet = common.quiet || params.stream;
  if (!quiet) reports::PrintFacts(facts, summary);
  watch.End(map, facts, quiet, summary);
}

}  // namespace

Command AddLocalizeCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "localize",
      "Localizes a robot on a map of the ceiling, from any start, and tracks it.",
      "ceilmap localize lab.gpkg --rig rig2.yaml --up up2.mp4 --stamps frames2.csv -o robot2.tum\n"
      "  ceilmap localize lab.gpkg --rig rig2.yaml --up run.mcap --up-topic /up/image_raw -o "
      "robot2.tum\n"
      "A SOURCE is a video file, a folder or printf pattern of images, a bag of ROS, /dev/videoN, "
      "or "
      "a URL.");
  auto params = std::make_shared<LocalizeOptions>();
  CLI::App& cli = *command.cli;
  const std::string result = LocalizeInputs::kResult;
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  params->inputs.AddTo(cli, "--frame");
  add("-o,--output", params->output, "Poses of all frames found; T.mcap: a bag", "T.tum")
      ->required()
      ->group(result);
  add("--status", params->status, "Pose, status and accuracy of every frame", "S.csv")
      ->group(result);
  add("--hypotheses",
      params->hypotheses,
      "Places where the robot may be, while it is ambiguous: timestamp,x,y,yaw_deg,weight",
      "P.csv")
      ->group(result);
  params->frame.AddTo(cli)->group(result);
  cli.add_flag("--stream", params->stream, "Poses to stdout as they are found, instead of a report")
      ->group(result);
  cli.add_flag("--predicted",
               params->predicted,
               "Write poses also where --odometry alone knows them (status predicted)")
      ->group(result);
  params->watch.AddTo(cli, result);
  params->plan.AddTo(cli)->group(result);
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunLocalize(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
