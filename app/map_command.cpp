#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>

#include "app/arguments.hpp"
#include "app/clock.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/frame_source.hpp"
#include "app/heading_meter.hpp"
#include "app/interrupt.hpp"
#include "app/map_append.hpp"
#include "app/map_report.hpp"
#include "app/measured_frames.hpp"
#include "app/output_files.hpp"
#include "app/progress.hpp"
#include "app/robot_rig.hpp"
#include "app/run_watch.hpp"
#include "app/tilt_meter.hpp"
#include "app/tum.hpp"
#include "calib/base/error.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/level_view.hpp"
#include "calib/rig.hpp"
#include "mapping/export.hpp"
#include "mapping/mapper.hpp"

namespace fs = std::filesystem;

namespace ceilmap::app {
namespace {

using std::chrono::steady_clock;

struct MapParams {
  fs::path rig;
  std::string up;
  fs::path stamps;
  std::string origin;
  Pose2 T_map_first;  // --origin, parsed
  std::optional<double> resolution;
  bool append = false;
  HeadingOptions heading;
  TiltOptions tilt;
  fs::path output;
  fs::path trajectory;
  fs::path picture;
  WatchOptions watch;

  // Checks everything that can be told without the recording. @throws InputError
  void Resolve();
};

void MapParams::Resolve() {
  if (append && !origin.empty()) {
    throw InputError("--origin: with --append the map has its origin already; leave it out");
  }
  heading.Check(!rig.empty());
  tilt.Check(!rig.empty());
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
  if (!origin.empty()) T_map_first = ParsePose2(origin, "--origin");
  CheckOutputFiles({output, trajectory, tilt.uncompensated, picture});
  watch.Check();
}

calib::CeilingView MakeView(const std::optional<calib::Rig>& rig,
                            const MapParams& params,
                            const FrameSource& source) {
  if (!rig) return calib::CeilingView::InPixels(source.Size());
  return {UpCameraOf(*rig, params.rig, source), rig->ceiling_height_m};
}

std::string UtcNow() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z",
                     utc.tm_year + 1900,
                     utc.tm_mon + 1,
                     utc.tm_mday,
                     utc.tm_hour,
                     utc.tm_min,
                     utc.tm_sec);
}

mapping::MapMetadata Describe(const std::optional<calib::Rig>& rig,
                              const calib::CeilingView& view,
                              const MapParams& params,
                              const CommonOptions& common) {
  mapping::MapMetadata metadata;
  metadata.unit = rig ? "m" : "px";
  metadata.resolution = params.resolution.value_or(view.MetresPerPixel());
  if (rig) {
    metadata.ceiling_height_m = rig->ceiling_height_m;
    metadata.rig_yaml = rig->source_yaml;
    metadata.robot = rig->robot;
  }
  metadata.view_size = view.Size();
  metadata.view_units_per_px = view.MetresPerPixel();
  metadata.T_base_view = view.T_base_view();
  metadata.view_mask = view.Mask();
  metadata.program_version = CEILMAP_VERSION;
  metadata.provenance = fmt::format("{}; from {}; {}", common.command_line, params.up, UtcNow());
  return metadata;
}

// What the map rests on without anybody having said so. Told at the end, so that an error before it
// stays one line.
void TellAssumptions(bool have_rig, StampOrigin stamps) {
  if (!have_rig) Note("no --rig: lengths are in pixels of the recording, not in metres");
  if (stamps == StampOrigin::kFrameIndex) {
    Note("no --stamps: pictures are taken to be one second apart");
  }
}

void MapFrames(FrameSource& source,
               TiltMeter* tilt,
               HeadingMeter* heading,
               mapping::Mapper& mapper,
               RunWatch& watch) {
  Progress progress("mapping", "frames", source.ExpectedFrames());
  MeasuredFrames frames(source, tilt, heading);
  MeasuredFrame measured;
  std::int64_t done = 0;
  while (frames.Read(measured)) {
    const Frame& frame = measured.frame;
    const mapping::FramePose pose =
        mapper.Process(frame.picture, frame.index, frame.stamp_s, measured.context);
    frames.Locate(pose.status == mapping::TrackingStatus::kTracking ? std::optional(pose.T_map_base)
                                                                    : std::nullopt);
    watch.AddMapped(pose, frame.picture, source.ExpectedFrames());
    progress.Update(++done);
    Detail("frame {} at {:.6f} s: {}", frame.index, frame.stamp_s, mapping::ToString(pose.status));
  }
}

// A camera is always ended this way, so it is no error once there is something to keep.
void TellInterrupted(const mapping::Mapper& mapper) {
  if (mapper.Trajectory().empty()) {
    throw RunError("interrupted before any frame was mapped; nothing was written");
  }
  PrintNote(fmt::format("interrupted: {} frames were kept", mapper.Trajectory().size()));
}

void FinishMap(mapping::Mapper& mapper) {
  Progress progress("drawing", "tiles");
  mapper.Finish([&progress](int done, int total) { progress.Update(done, total); });
}

std::string TrajectoryText(const std::vector<mapping::FramePose>& frames) {
  std::vector<StampedPose> poses;
  poses.reserve(frames.size());
  for (const mapping::FramePose& frame : frames) {
    poses.push_back(ToStampedPose(frame.stamp_s, frame.T_map_base, frame.tilt));
  }
  return FormatTum(poses);
}

// Without a rig there is no tilt: both trajectories are the same.
std::string UncompensatedText(const std::vector<mapping::FramePose>& frames,
                              const calib::CeilingView& view) {
  if (!(view.FocalLength() > 0)) return TrajectoryText(frames);
  const calib::LevelView level(view);
  std::vector<StampedPose> poses;
  poses.reserve(frames.size());
  for (const mapping::FramePose& frame : frames) {
    poses.push_back(
        ToStampedPose(frame.stamp_s, level.Uncompensated(frame.T_map_base, frame.tilt)));
  }
  return FormatTum(poses);
}

// The map and the trajectories appear together, or none of them.
void CommitFiles(const std::vector<mapping::FramePose>& frames,
                 const calib::CeilingView& view,
                 mapping::MapWriter& writer,
                 const MapParams& params,
                 Summary& summary) {
  std::vector<std::unique_ptr<AtomicFile>> trajectories;
  const auto write = [&trajectories](const fs::path& file, const std::string& text) {
    if (file.empty()) return;
    trajectories.push_back(std::make_unique<AtomicFile>(file));
    WriteText(*trajectories.back(), text);
  };
  write(params.trajectory, TrajectoryText(frames));
  write(params.tilt.uncompensated, UncompensatedText(frames, view));
  writer.Commit();
  summary.files.push_back(params.output);
  for (const auto& trajectory : trajectories) {
    trajectory->Commit();
    summary.files.push_back(trajectory->Target());
  }
  if (!params.picture.empty()) {
    mapping::ExportPng(mapping::MapReader(params.output), params.picture);
    summary.files.push_back(params.picture);
  }
}

void RunMap(MapParams params, const CommonOptions& common, Summary& summary) {
  const auto start = steady_clock::now();
  params.Resolve();
  const std::optional<calib::Rig> rig =
      params.rig.empty() ? std::nullopt : std::optional(calib::ReadRig(params.rig));
  FrameSource source(params.up, {.stamps = params.stamps});
  const calib::CeilingView view = MakeView(rig, params, source);
  const std::unique_ptr<TiltMeter> tilt =
      TiltMeter::Make(params.tilt, rig, params.rig, params.stamps);
  const std::unique_ptr<HeadingMeter> heading =
      HeadingMeter::Make(params.heading, rig, params.rig, params.stamps);

  const mapping::MapMetadata metadata = Describe(rig, view, params, common);
  mapping::MapperParams mapper_params;
  mapper_params.origin = params.T_map_first;
  mapper_params.mosaic.resolution = metadata.resolution;
  std::optional<Appending> appending;
  if (params.append) {
    appending.emplace(params.output, metadata, params.resolution);
    mapper_params.first_keyframe_id = appending->NextKeyframeId();
  }
  mapping::MapWriter writer(params.output, appending ? appending->Metadata() : metadata);
  if (appending) appending->CheckCurrent();
  mapping::Mapper mapper(view, writer, metadata, mapper_params);

  page::PageData page;
  page.title = fmt::format("Map {}", params.output.filename().string());
  page.unit = metadata.unit;
  RunWatch watch(params.watch, params.up, std::move(page), view);
  MapFrames(source, tilt.get(), heading.get(), mapper, watch);
  for (const std::string& warning : source.Warnings()) PrintWarning(warning);
  if (tilt) {
    for (const std::string& warning : tilt->Warnings()) PrintWarning(warning);
  }
  if (heading) {
    for (const std::string& warning : heading->Warnings()) PrintWarning(warning);
  }
  if (Interrupted()) TellInterrupted(mapper);
  MapResult result;
  if (appending) {
    result = appending->Finish(params.up, view, mapper, writer);
  } else {
    FinishMap(mapper);
    result = {nullptr, nullptr, mapper.Trajectory(), mapper.Report(), mapper.Graph().weak_spots};
  }
  result.tilt = tilt.get();
  result.heading = heading.get();
  CommitFiles(result.frames, view, writer, params, summary);
  TellAssumptions(rig.has_value(), source.Stamps());

  const Table facts = FactsOf(result, metadata.unit, SecondsSince(start));
  Summarize(result, source.Report(), metadata.unit, summary);
  WarnOfParts(result);
  if (!common.quiet) PrintFacts(facts, summary);
  if (!watch.Wanted()) return;
  watch.Replace(result.frames);
  watch.End(mapping::MapReader(params.output), facts, common.quiet, summary);
}

}  // namespace

Command AddMapCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "map",
      "Makes a map of the ceiling, and the robot's trajectory, from a recording.",
      "ceilmap map --rig rig.yaml --up up.mp4 --stamps frames.csv -o lab.gpkg --trajectory "
      "lab.tum\n"
      "A SOURCE is a video file, a folder or printf pattern of pictures, /dev/videoN, or a URL.");
  auto params = std::make_shared<MapParams>();
  CLI::App& cli = *command.cli;
  const std::string input = "Input";
  const std::string result = "Results";
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  add("--rig", params->rig, "The robot's cameras; without it the map is in pixels", "RIG.yaml")
      ->group(input);
  add("--up", params->up, "Upward camera", "SOURCE")->required()->group(input);
  add("--stamps", params->stamps, "Time of each frame: index,timestamp", "FRAMES.csv")
      ->group(input);
  add("--origin", params->origin, "Pose of the first frame on the map", "X,Y,YAW_DEG")
      ->group(input);
  cli.add_flag("--append",
               params->append,
               "Extend the map, wherever on it the recording begins; it stays as it was if nothing "
               "is seen in both")
      ->group(result);
  add("--resolution", params->resolution, "Metres per map pixel [that of the camera]", "M")
      ->group(result);
  add("-o,--output", params->output, "The map", "MAP.gpkg")->required()->group(result);
  add("--trajectory", params->trajectory, "Poses of all frames found", "T.tum")->group(result);
  params->tilt.AddTo(cli, input, result);
  params->heading.AddTo(cli, input, input);
  add("--picture", params->picture, "The mosaic as seen from above", "FILE.png")->group(result);
  params->watch.AddTo(cli, result);
  command.run = [params](const CommonOptions& common, Summary& summary) {
    RunMap(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::app
