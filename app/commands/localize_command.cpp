#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <optional>

#include "app/commands/commands.hpp"
#include "app/commands/frame_option.hpp"
#include "app/commands/localize_files.hpp"
#include "app/commands/localize_tally.hpp"
#include "app/commands/plan_option.hpp"
#include "app/commands/sensor_options.hpp"
#include "app/commands/settings_options.hpp"
#include "app/files/arguments.hpp"
#include "app/files/output_files.hpp"
#include "app/live/run_watch.hpp"
#include "app/recordings/bag_options.hpp"
#include "app/recordings/bag_rig.hpp"
#include "app/recordings/bitrate.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/recordings/rig_warnings.hpp"
#include "app/recordings/sensor_inputs.hpp"
#include "app/reports/localize_report.hpp"
#include "app/reports/page_parts.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"
#include "calib/base/yaml_value.hpp"
#include "calib/rig.hpp"
#include "calib/robot_rig.hpp"
#include "localization/robot/ceiling_localizer.hpp"
#include "mapping/store/map_file.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using std::chrono::steady_clock;

struct LocalizeOptions {
  fs::path map;
  fs::path rig;
  bool rig_from_bag = false;
  std::string up;
  fs::path stamps;
  std::string start;
  std::string start_spread = "0.5,10";
  SensorOptions sensors;
  recordings::BagOptions bags;
  std::string heading_zero = "first";
  fs::path output;
  fs::path status;
  fs::path hypotheses;
  bool stream = false;
  bool predicted = false;
  FrameOption frame;
  PlanOption plan;
  live::WatchOptions watch;
  SettingsOptions settings;

  // Checks everything that can be checked without the recording. @throws InputError
  void Check(files::Existing existing) const;
  [[nodiscard]] localization::LocalizerParams ForLocalizer(
      localization::LocalizerParams params, const std::optional<survey::SiteFrame>& site) const;
  [[nodiscard]] LocalizeOutputs Outputs(const std::optional<survey::SiteFrame>& site) const {
    return {output, sensors.uncompensated, status, hypotheses, predicted, stream, site};
  }
  // The building's coordinates for --frame site. @throws InputError when the map has none.
  [[nodiscard]] std::optional<survey::SiteFrame> Site() const;
};

void LocalizeOptions::Check(files::Existing existing) const {
  sensors.Check(true);
  if (rig_from_bag && !rig.empty()) {
    throw InputError("--rig-from-bag and --rig: give one of the two");
  }
  if (predicted && sensors.wheels.odometry.empty()) {
    throw InputError("--predicted: poses are predicted by wheels; give --odometry");
  }
  if (!sensors.heading_model.empty() && heading_zero != "first") {
    throw InputError(
        "--heading-zero: headings of --heading-model are relative to the map's x axis; leave it "
        "out");
  }
  if (!sensors.omni.empty() && heading_zero != "first") {
    throw InputError(
        "--heading-zero: headings of --omni are relative to the first frame; leave it out");
  }
  if (frame.Value() == store::Frame::kSite &&
      (files::IsBagName(output) || files::IsBagName(sensors.uncompensated))) {
    throw InputError("--frame site: bags are in the map's coordinates; give T.tum as the output");
  }
  std::error_code ignored;
  for (const fs::path& target :
       {output, sensors.uncompensated, status, hypotheses, sensors.wheels.rig_out}) {
    for (const fs::path& source : {map,
                                   rig,
                                   stamps,
                                   sensors.heading,
                                   sensors.heading_model,
                                   sensors.wheels.odometry,
                                   sensors.wheels.gyro,
                                   fs::path(up)}) {
      if (target.empty() || source.empty() || !fs::equivalent(target, source, ignored)) continue;
      throw InputError(
          fmt::format("{}: is read by this run and cannot be its result too", target.string()));
    }
  }
  plan.CheckHasPage(watch.HasPage());
  files::CheckOutputFiles(
      {output, sensors.uncompensated, status, hypotheses, sensors.wheels.rig_out}, existing);
  watch.Check(existing);
}

std::optional<survey::SiteFrame> LocalizeOptions::Site() const {
  if (frame.Value() == store::Frame::kMap) return std::nullopt;
  return *store::SiteOf(store::MapReader(map), frame.Value());
}

localization::LocalizerParams LocalizeOptions::ForLocalizer(
    localization::LocalizerParams params, const std::optional<survey::SiteFrame>& site) const {
  const files::PoseSpread spread = files::ParseSpread(start_spread, "--start-spread");
  if (!start.empty()) {
    PoseWithCovariance pose{files::ParsePose2(start, "--start")};
    const double position = spread.position_m * spread.position_m;
    pose.covariance.diagonal() << position, position, spread.yaw_rad * spread.yaw_rad;
    params.start = site ? survey::ToMap(*site, pose) : pose;
  }
  return params;
}

void LocateFrames(recordings::FrameSource& source,
                  recordings::SensorInputs& sensors,
                  robot::CeilingLocalizer& localizer,
                  LocalizeFiles& results,
                  live::RunWatch& watch,
                  reports::LocalizeResult& result) {
  terminal::Progress progress("localizing", "frames", source.ExpectedFrames());
  sensors.AddHeadings(localizer);
  LocalizeTally tally;
  std::int64_t done = 0;
  const auto report = [&](const robot::Estimate& estimate) {
    results.Add(estimate);
    tally.Add(estimate, result);
    watch.Add(robot::ToFramePose(estimate), source.ExpectedFrames());
    progress.Update(++done);
    reports::PrintDetail(estimate);
  };
  for (recordings::Frame frame; source.Read(frame); frame = {}) {
    sensors.ReadTo(frame.stamp_s, localizer);
    const robot::Image up{frame.image, frame.stamp_s, frame.index, frame.encoding};
    if (source.IsLive()) {
      report(localizer.AddCeiling(up));
      result.latency.Add(1e3 * (source.Now() - frame.arrival_s));
    } else if (const auto estimate = localizer.AddCeilingPipelined(up)) {
      report(*estimate);
    }
  }
  if (const auto estimate = localizer.Flush()) report(*estimate);
}

// The error for a run without any pose, with its likely cause.
[[noreturn]] void ReportNothingFound(const LocalizeOptions& params,
                                     const reports::LocalizeResult& result) {
  if (terminal::Interrupted()) {
    throw RunError(fmt::format("interrupted after {} frames, before any could be placed",
                               result.report.frames));
  }
  throw RunError(reports::CoverageFailure(reports::CoverageOf(result), params.up));
}

// Warnings about differences between rig and map. The map's values are used.
void WarnOfScale(const calib::Rig& rig,
                 const store::MapMetadata& map,
                 const reports::LocalizeResult& result) {
  constexpr double kNotable = 0.01;
  if (std::abs(rig.ceiling_height_m / map.ceiling_height_m - 1) > kNotable) {
    terminal::Warn(
        "the ceiling height is {} m in the rig and {} m in the map: the map's height is used",
        rig.ceiling_height_m,
        map.ceiling_height_m);
  }
  const double scale = result.report.scale.value_or(1);
  if (std::abs(scale - 1) > kNotable) {
    terminal::Warn(
        "the ceiling appears {:.1f} % {} than by the rig; check the camera's height and focal "
        "length",
        100 * std::abs(scale - 1),
        scale > 1 ? "larger" : "smaller");
  }
}

// Initial content of the live page: the map.
page::PageData StartOfPage(const LocalizeOptions& params,
                           const store::MapReader& map,
                           const std::optional<reports::PageSite>& site) {
  page::PageData page;
  page.title = fmt::format("{} on {}",
                           fs::path(params.up).filename().string(),
                           fs::path(WithoutSecrets(params.map.string())).filename().string());
  if (params.watch.Live()) reports::AddMap(map, site, page);
  return page;
}

calib::Rig RigFor(const LocalizeOptions& params) {
  if (!params.rig.empty()) return calib::ReadRig(params.rig);
  const store::MapMetadata map = store::MapReader(params.map).Metadata();
  if (params.rig_from_bag) {
    return recordings::ReadBagRig(params.up,
                                  params.bags.Topic("up"),
                                  params.sensors.forward,
                                  params.bags.Topic("forward"),
                                  map.ceiling_height_m);
  }
  const std::string& text = map.rig_yaml;
  const std::string name = WithoutSecrets(params.map.string());
  if (text.empty()) {
    throw InputError(fmt::format("{}: was made without a rig; give --rig", name));
  }
  if (text.size() > kMaxSettingsBytes) {
    throw InputError(fmt::format("{}: its rig is larger than 1 MiB; give --rig", name));
  }
  try {
    return calib::ParseRig(text, name + " (its rig)");
  } catch (const InputError& error) {  // such as a camera_info file that is not here
    throw InputError(fmt::format("{}; or give --rig", error.what()));
  }
}

recordings::SensorFiles FilesFor(const LocalizeOptions& params) {
  const HeadingFrame headings_frame =
      params.heading_zero == "map" ? HeadingFrame::kMap : HeadingFrame::kRelative;
  return params.sensors.Files(true, params.stamps, headings_frame, params.bags);
}

void PrintNotes(const LocalizeOptions& params, const reports::LocalizeResult& result) {
  if (terminal::Interrupted()) {
    terminal::PrintNote(fmt::format("interrupted: {} frames were located", result.report.frames));
  }
  if (result.stamps == recordings::StampOrigin::kFrameIndex) {
    terminal::Note("no --stamps: images are taken to be one second apart");
  }
  if (params.rig.empty() && !params.rig_from_bag) {
    terminal::Note("no --rig: the camera is taken to be that of the robot that made the map");
  }
}

void RunLocalize(LocalizeOptions params, const CommonOptions& common, terminal::Summary& summary) {
  const auto start = steady_clock::now();
  params.sensors.TakeBag(params.bags, params.up);
  params.Check(common.Existing());
  const CommandSettings settings = params.settings.Read();
  summary.settings = SettingsJson(settings, {"localization", "sensors"});
  robot::CeilingLocalizerParams localizer_params;
  const std::optional<survey::SiteFrame> site = params.Site();
  std::optional<reports::PageSite> page_site;
  if (params.watch.HasPage()) {
    page_site = params.plan.Site(store::MapReader(params.map), params.frame.Value());
  }
  localizer_params.localization = params.ForLocalizer(settings.localization, site);
  std::optional<calib::Rig> rig = RigFor(params);
  const recordings::SensorFiles files = FilesFor(params);
  recordings::ReserveTopics(files);
  recordings::FrameSource source(
      params.up,
      recordings::FrameSourceOptions{.stamps = params.stamps, .bag = params.bags.Topic("up")}
          .ForNewest());
  const auto scaling = calib::FitUpCamera(*rig, source.Name(), source.Size());
  recordings::SensorInputs sensors(files, rig);
  params.bags.Bags().ReleaseReserved();
  localizer_params.sensors = sensors.Params(settings.sensors);
  robot::CeilingLocalizer localizer(params.map, *rig, localizer_params);
  const store::MapReader& map = localizer.Map();

  reports::LocalizeResult result;
  LocalizeFiles results(params.Outputs(site), calib::LevelView(localizer.View()));
  page::PageData page = StartOfPage(params, map, page_site);
  live::RunWatch watch(params.watch, params.up, std::move(page), localizer.View(), page_site);
  if (!params.rig.empty()) recordings::PrintRigWarnings(*rig);
  if (!params.rig_from_bag) {
    recordings::PrintCameraDifferences(*rig, params.up, params.bags.Topic("up"), files);
  }
  LocateFrames(source, sensors, localizer, results, watch, result);
  result.sensors = {&sensors, localizer.Sensed()};
  for (const std::string& warning : source.Warnings()) terminal::PrintWarning(warning);
  for (const std::string& warning : reports::Warnings(result.sensors)) {
    terminal::PrintWarning(warning);
  }
  result.report = localizer.Report();
  result.reading = source.Report();
  result.bits_per_px = recordings::BitsPerPixel(params.up, result.reading.decoded, source.Size());
  result.stamps = source.Stamps();
  result.has_start = !params.start.empty();
  result.seconds = terminal::SecondsSince(start);
  if (result.Placed() == 0) {
    results.CommitStatus();  // the file shows the reason
    ReportNothingFound(params, result);
  }
  results.Commit(summary);
  params.sensors.wheels.WriteRig(*rig, result.sensors.report.wheels, summary);
  PrintNotes(params, result);
  reports::ReportScalings(scaling, sensors);
  WarnOfScale(*rig, map.Metadata(), result);
  const reports::Coverage coverage = reports::CoverageOf(result);
  for (const std::string& warning :
       reports::RecordingWarnings(reports::RecordingFactsOf(result, params.up))) {
    terminal::PrintWarning(warning);
  }
  if (const auto warning = reports::CoverageWarning(coverage)) terminal::PrintWarning(*warning);
  summary.failure = reports::CoverageFailure(coverage, params.up);
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
  const std::string input = "Input";
  const std::string prior = "Prior knowledge";
  const std::string result = "Results";
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  add("map", params->map, "The map, made with --rig", "MAP.gpkg")->required()->group(input);
  add("--rig", params->rig, "This robot's cameras [those of the map's robot]", "RIG.yaml")
      ->group(input);
  cli.add_flag("--rig-from-bag",
               params->rig_from_bag,
               "Without --rig: the cameras by the camera_info and /tf_static of the bag of --up")
      ->group(input);
  add("--up", params->up, "Upward camera", "SOURCE")->required()->group(input);
  add("--stamps", params->stamps, "Time of each frame: index,timestamp", "FRAMES.csv")
      ->group(input);
  add("--start",
      params->start,
      "Pose of the first frame, in the coordinates of --frame [anywhere on the map]",
      "X,Y,YAW_DEG")
      ->group(prior);
  add("--start-spread", params->start_spread, "Standard deviations of --start", "M,DEG")
      ->capture_default_str()
      ->group(prior);
  params->sensors.AddTo(cli, input, prior, result);
  params->sensors.AddModelTo(cli, prior);
  params->bags.AddTo(cli, SensorOptions::BagSources());
  add("--heading-zero",
      params->heading_zero,
      "Zero direction of the headings: the first frame (or any other unknown direction), or the "
      "map's x "
      "axis",
      "ZERO")
      ->check(CLI::IsMember({"first", "map"}))
      ->capture_default_str()
      ->group(prior);
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
  params->settings.AddTo(cli);
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunLocalize(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
