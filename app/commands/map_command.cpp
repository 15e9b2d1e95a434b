#include <fmt/format.h>

#include <chrono>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>

#include "app/commands/commands.hpp"
#include "app/commands/map_trajectories.hpp"
#include "app/commands/rig_options.hpp"
#include "app/commands/sensor_options.hpp"
#include "app/commands/settings_options.hpp"
#include "app/files/arguments.hpp"
#include "app/files/output_files.hpp"
#include "app/live/run_watch.hpp"
#include "app/recordings/bag_options.hpp"
#include "app/recordings/bitrate.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/recordings/rig_warnings.hpp"
#include "app/recordings/sensor_inputs.hpp"
#include "app/reports/map_report.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "calib/base/result_date.hpp"
#include "calib/rig.hpp"
#include "calib/robot_rig.hpp"
#include "localization/robot/ceiling_mapper.hpp"
#include "mapping/store/export.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using std::chrono::steady_clock;

struct MapOptions {
  RigOptions rig;
  std::string up;
  fs::path stamps;
  std::string origin;
  Pose2 T_map_first;  // --origin, parsed
  std::optional<double> resolution;
  bool append = false;
  SensorOptions sensors;
  recordings::BagOptions bags;
  fs::path output;
  fs::path trajectory;
  bool predicted = false;
  fs::path picture;
  live::WatchOptions watch;
  SettingsOptions settings;

  // Checks everything that can be checked without the recording. @throws InputError
  void Resolve(files::Existing existing);
};

void MapOptions::Resolve(files::Existing existing) {
  if (append && !origin.empty()) {
    throw InputError("--origin: with --append the map has its origin already; leave it out");
  }
  rig.Check();
  sensors.TakeBag(bags, up);
  if (rig.IsNominal() && !(sensors.forward.empty() && sensors.omni.empty())) {
    throw InputError(fmt::format("{}: --fov describes the upward camera alone; give --rig",
                                 sensors.forward.empty() ? "--omni" : "--forward"));
  }
  // The distortion of an uncalibrated lens looks like tilt.
  if (rig.IsNominal() && sensors.tilt.empty()) sensors.tilt = "none";
  sensors.Check(rig.IsGiven());
  if (predicted && sensors.wheels.odometry.empty()) {
    throw InputError("--predicted: poses are predicted by wheels; give --odometry");
  }
  if (output.extension() != ".gpkg") {
    throw InputError(fmt::format("{}: the map's name must end in .gpkg", output.string()));
  }
  if (!picture.empty() && picture.extension() != ".png") {
    throw InputError(fmt::format("{}: the picture's name must end in .png", picture.string()));
  }
  if (resolution && !(*resolution > 0 && *resolution < 1e6)) {
    throw InputError(
        fmt::format("--resolution {}: must be > 0, metres per pixel of the map", *resolution));
  }
  if (!origin.empty()) T_map_first = files::ParsePose2(origin, "--origin");
  files::CheckOutputFiles(
      {output, trajectory, sensors.uncompensated, picture, sensors.wheels.rig_out},
      existing,
      append ? output : fs::path());
  watch.Check(existing);
  for (const fs::path& file : {trajectory, sensors.uncompensated}) {
    if (rig.IsGiven() || !files::IsBagName(file)) continue;
    throw InputError(
        fmt::format("{}: poses are in pixels without a rig, and those of a bag in metres; give "
                    "--rig, or a name that ends in .tum",
                    file.string()));
  }
}

std::string ProvenanceOf(const MapOptions& params, const CommonOptions& common) {
  return fmt::format("{}; from {}; {}", common.command_line, params.up, ResultDate());
}

robot::CeilingMapper MakeMapper(const std::optional<calib::Rig>& rig,
                                const recordings::FrameSource& source,
                                const MapOptions& params,
                                const robot::CeilingMapperParams& mapper) {
  try {
    if (!rig) return {source.Size(), params.output, mapper};
    return {*rig, params.output, mapper};
  } catch (const InputError& error) {
    if (!params.append) throw;
    throw InputError(fmt::format("--append: {}", error.what()));
  }
}

// Notes about assumptions of the map. They are printed at the end, so that an earlier error stays
// one line.
void ReportAssumptions(const RigOptions& rig, recordings::StampOrigin stamps) {
  if (const std::string text = rig.Assumption(); !text.empty()) terminal::PrintNote(text);
  if (stamps == recordings::StampOrigin::kFrameIndex) {
    terminal::Note("no --stamps: images are taken to be one second apart");
  }
}

void MapFrames(recordings::FrameSource& source,
               recordings::SensorInputs& sensors,
               robot::CeilingMapper& mapper,
               MapTrajectories& trajectories,
               live::RunWatch& watch,
               reports::MapResult& result) {
  terminal::Progress progress("mapping", "frames", source.ExpectedFrames());
  sensors.AddHeadings(mapper);
  std::int64_t done = 0;
  const auto report = [&](const robot::Estimate& estimate) {
    trajectories.Note(estimate);
    watch.AddMapped(robot::ToFramePose(estimate), mapper.Rectified(), source.ExpectedFrames());
    progress.Update(++done);
    reports::PrintDetail(estimate);
  };
  for (recordings::Frame frame; source.Read(frame); frame = {}) {
    sensors.ReadTo(frame.stamp_s, mapper);
    const robot::Image up{frame.image, frame.stamp_s, frame.index, frame.encoding};
    if (source.IsLive()) {
      report(mapper.AddCeiling(up));
      result.latency.Add(1e3 * (source.Now() - frame.arrival_s));
    } else if (const auto estimate = mapper.AddCeilingPipelined(up)) {
      report(*estimate);
    }
  }
  if (const auto estimate = mapper.Flush()) report(*estimate);
}

// A camera is always stopped by an interruption, so it is no error if frames were mapped.
void ReportInterrupted(const robot::CeilingMapper& mapper) {
  if (mapper.PlacedFrames() == 0) {
    throw RunError("interrupted before any frame was mapped; nothing was written");
  }
  terminal::PrintNote(fmt::format("interrupted: {} frames were kept", mapper.PlacedFrames()));
}

mapping::MappingResult DrawMap(const MapOptions& params, robot::CeilingMapper& mapper) {
  terminal::Progress progress("drawing", "tiles");
  const auto show = [&progress](int done, int total) { progress.Update(done, total); };
  try {
    return mapper.Draw(show);
  } catch (const RunError& error) {
    if (!params.append) throw;
    throw RunError(fmt::format("--append: {}", error.what()));
  }
}

// The map and the trajectories are written together, or none of them.
void CommitFiles(const MapOptions& params,
                 const mapping::MappingResult& map,
                 MapTrajectories& trajectories,
                 robot::CeilingMapper& mapper,
                 terminal::Summary& summary) {
  trajectories.Write(map, mapper.View());
  mapper.Commit();
  summary.files.push_back(params.output);
  trajectories.Commit(summary);
  if (!params.picture.empty()) {
    store::ExportPng(store::MapReader(params.output), params.picture);
    summary.files.push_back(params.picture);
  }
}

robot::CeilingMapperParams MapperParamsFor(const MapOptions& params,
                                           const CommonOptions& common,
                                           const recordings::SensorInputs& sensors,
                                           const CommandSettings& settings) {
  robot::CeilingMapperParams mapper;
  mapper.sensors = sensors.Params(settings.sensors);
  mapper.mapping = settings.mapping;
  mapper.mapping.origin = params.T_map_first;
  if (params.append) mapper.append = mapping::HeldPoses::kFirstKeyframe;
  mapper.resolution = params.resolution;
  mapper.source = params.up;
  mapper.provenance = ProvenanceOf(params, common);
  return mapper;
}

void RunMap(MapOptions params, const CommonOptions& common, terminal::Summary& summary) {
  const auto start = steady_clock::now();
  params.Resolve(common.Existing());
  const CommandSettings settings = params.settings.Read();
  summary.settings = SettingsJson(settings, {"mapping", "sensors"});
  std::optional<calib::Rig> rig = params.rig.ReadFile();
  const recordings::SensorFiles files = params.sensors.Files(
      params.rig.IsGiven(), params.stamps, HeadingFrame::kRelative, params.bags);
  if (params.rig.from_bag) rig = params.rig.OfBag(params.up, files.forward, params.bags);
  recordings::ReserveTopics(files);
  recordings::FrameSource source(params.up,
                                 {.stamps = params.stamps, .bag = params.bags.Topic("up")});
  if (params.rig.IsNominal()) rig = params.rig.Nominal(source.Size());
  std::optional<calib::CameraScaling> scaling;
  if (rig) scaling = calib::FitUpCamera(*rig, source.Name(), source.Size());
  recordings::SensorInputs sensors(files, rig);
  params.bags.Bags().ReleaseReserved();
  robot::CeilingMapper mapper =
      MakeMapper(rig, source, params, MapperParamsFor(params, common, sensors, settings));
  const std::string unit = mapper.Metadata().unit;

  page::PageData page;
  page.title = fmt::format("Map {}", params.output.filename().string());
  page.unit = unit;
  live::RunWatch watch(params.watch, params.up, std::move(page), mapper.View());
  if (rig && !params.rig.IsNominal()) recordings::PrintRigWarnings(*rig);
  if (!params.rig.file.empty()) {
    recordings::PrintCameraDifferences(*rig, params.up, params.bags.Topic("up"), files);
  }
  MapTrajectories trajectories(params.trajectory, params.sensors.uncompensated, params.predicted);
  reports::MapResult result;
  MapFrames(source, sensors, mapper, trajectories, watch, result);
  result.sensors = {&sensors, mapper.Sensed()};
  result.reading = source.Report();
  result.stamps = source.Stamps();
  result.bits_per_px = recordings::BitsPerPixel(params.up, result.reading.decoded, source.Size());
  for (const std::string& warning : source.Warnings()) terminal::PrintWarning(warning);
  for (const std::string& warning : reports::Warnings(result.sensors)) {
    terminal::PrintWarning(warning);
  }
  if (terminal::Interrupted()) ReportInterrupted(mapper);
  result.map = DrawMap(params, mapper);
  CommitFiles(params, result.map, trajectories, mapper, summary);
  if (rig) params.sensors.wheels.WriteRig(*rig, result.sensors.report.wheels, summary);
  ReportAssumptions(params.rig, source.Stamps());
  reports::ReportScalings(scaling, sensors);

  const terminal::Table facts = reports::FactsOf(result, unit, terminal::SecondsSince(start));
  reports::Summarize(result, unit, summary);
  for (const std::string& warning :
       reports::RecordingWarnings(reports::RecordingFactsOf(result, params.up))) {
    terminal::PrintWarning(warning);
  }
  reports::ReportCoverage(result, params.up, summary);
  if (!common.quiet) reports::PrintFacts(facts, summary);
  if (!watch.Wanted()) return;
  watch.Replace(PlacedFrames(result.map));
  watch.End(store::MapReader(params.output), facts, common.quiet, summary);
}

}  // namespace

Command AddMapCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "map",
      "Creates a map of the ceiling, and the robot's trajectory, from a recording.",
      "ceilmap map --rig rig.yaml --up up.mp4 --stamps frames.csv -o lab.gpkg --trajectory "
      "lab.tum\n"
      "  ceilmap map --rig rig.yaml --up run.mcap --up-topic /up/image_raw --odometry-topic /odom "
      "-o "
      "lab.gpkg\n"
      "A SOURCE is a video file, a folder or printf pattern of images, a bag of ROS, /dev/videoN, "
      "or "
      "a URL.");
  auto params = std::make_shared<MapOptions>();
  CLI::App& cli = *command.cli;
  const std::string input = "Input";
  const std::string result = "Results";
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  params->rig.AddTo(cli, input);
  add("--up", params->up, "Upward camera", "SOURCE")->required()->group(input);
  add("--stamps", params->stamps, "Time of each frame: index,timestamp", "FRAMES.csv")
      ->group(input);
  add("--origin", params->origin, "Pose of the first frame on the map", "X,Y,YAW_DEG")
      ->group(input);
  cli.add_flag("--append",
               params->append,
               "Extend this map; the recording may begin anywhere on it. The map is not changed if "
               "nothing matches")
      ->group(result);
  add("--resolution", params->resolution, "Metres per map pixel [that of the camera]", "M")
      ->group(result);
  add("-o,--output", params->output, "The map", "MAP.gpkg")->required()->group(result);
  add("--trajectory", params->trajectory, "Poses of all frames found; T.mcap: a bag", "T.tum")
      ->group(result);
  params->sensors.AddTo(cli, input, input, result);
  params->bags.AddTo(cli, SensorOptions::BagSources());
  cli.add_flag("--predicted",
               params->predicted,
               "Write poses also of frames that only --odometry places (status predicted)")
      ->group(result);
  add("--picture", params->picture, "The mosaic as seen from above", "FILE.png")->group(result);
  params->watch.AddTo(cli, result);
  params->settings.AddTo(cli);
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunMap(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
