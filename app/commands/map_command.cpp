#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>

#include "app/commands/commands.hpp"
#include "app/files/arguments.hpp"
#include "app/files/output_files.hpp"
#include "app/files/tum.hpp"
#include "app/live/run_watch.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/recordings/heading_source.hpp"
#include "app/recordings/robot_rig.hpp"
#include "app/recordings/sensor_fusion.hpp"
#include "app/recordings/tilt_source.hpp"
#include "app/reports/map_append.hpp"
#include "app/reports/map_report.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/level_view.hpp"
#include "calib/rig.hpp"
#include "mapping/mapper.hpp"
#include "mapping/store/export.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
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
  recordings::HeadingOptions heading;
  recordings::TiltOptions tilt;
  fs::path output;
  fs::path trajectory;
  fs::path image;
  live::WatchOptions watch;

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
  if (!image.empty() && image.extension() != ".png") {
    throw InputError(fmt::format("{}: the image's name must end in .png", image.string()));
  }
  if (resolution && !(*resolution > 0 && *resolution < 1e6)) {
    throw InputError(
        fmt::format("--resolution {}: must be > 0, metres per pixel of the map", *resolution));
  }
  if (!origin.empty()) T_map_first = files::ParsePose2(origin, "--origin");
  files::CheckOutputFiles({output, trajectory, tilt.uncompensated, image});
  watch.Check();
}

calib::CeilingView MakeView(const std::optional<calib::Rig>& rig,
                            const MapParams& params,
                            const recordings::FrameSource& source) {
  if (!rig) return calib::CeilingView::InPixels(source.Size());
  return {recordings::UpCameraOf(*rig, params.rig, source), rig->ceiling_height_m};
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

store::MapMetadata Describe(const std::optional<calib::Rig>& rig,
                            const calib::CeilingView& view,
                            const MapParams& params,
                            const CommonOptions& common) {
  store::MapMetadata metadata;
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
void ReportAssumptions(bool have_rig, recordings::StampOrigin stamps) {
  if (!have_rig) terminal::Note("no --rig: lengths are in pixels of the recording, not in metres");
  if (stamps == recordings::StampOrigin::kFrameIndex) {
    terminal::Note("no --stamps: images are taken to be one second apart");
  }
}

void MapFrames(recordings::FrameSource& source,
               recordings::TiltSource* tilt,
               recordings::HeadingSource* heading,
               mapping::Mapper& mapper,
               live::RunWatch& watch) {
  terminal::Progress progress("mapping", "frames", source.ExpectedFrames());
  recordings::SensorFusion frames(source, tilt, heading);
  recordings::MeasuredFrame measured;
  std::int64_t done = 0;
  while (frames.Read(measured)) {
    const recordings::Frame& frame = measured.frame;
    const graph::FramePose pose =
        mapper.Process(frame.image, frame.index, frame.stamp_s, measured.context);
    frames.Locate(pose.status == graph::TrackingStatus::kTracking ? std::optional(pose.T_map_base)
                                                                  : std::nullopt);
    watch.AddMapped(pose, frame.image, source.ExpectedFrames());
    progress.Update(++done);
    terminal::Detail(
        "frame {} at {:.6f} s: {}", frame.index, frame.stamp_s, graph::ToString(pose.status));
  }
}

// A camera is always ended this way, so it is no error once there is something to keep.
void ReportInterrupted(const mapping::Mapper& mapper) {
  if (mapper.Trajectory().empty()) {
    throw RunError("interrupted before any frame was mapped; nothing was written");
  }
  terminal::PrintNote(fmt::format("interrupted: {} frames were kept", mapper.Trajectory().size()));
}

void FinishMap(mapping::Mapper& mapper) {
  terminal::Progress progress("drawing", "tiles");
  mapper.Finish([&progress](int done, int total) { progress.Update(done, total); });
}

std::string TrajectoryText(const std::vector<graph::FramePose>& frames) {
  std::vector<StampedPose> poses;
  poses.reserve(frames.size());
  for (const graph::FramePose& frame : frames) {
    poses.push_back(ToStampedPose(frame.stamp_s, frame.T_map_base, frame.tilt));
  }
  return files::FormatTum(poses);
}

// Without a rig there is no tilt: both trajectories are the same.
std::string UncompensatedText(const std::vector<graph::FramePose>& frames,
                              const calib::CeilingView& view) {
  if (!(view.FocalLength() > 0)) return TrajectoryText(frames);
  const calib::LevelView level(view);
  std::vector<StampedPose> poses;
  poses.reserve(frames.size());
  for (const graph::FramePose& frame : frames) {
    poses.push_back(
        ToStampedPose(frame.stamp_s, level.Uncompensated(frame.T_map_base, frame.tilt)));
  }
  return files::FormatTum(poses);
}

// The map and the trajectories appear together, or none of them.
void CommitFiles(const std::vector<graph::FramePose>& frames,
                 const calib::CeilingView& view,
                 store::MapWriter& writer,
                 const MapParams& params,
                 terminal::Summary& summary) {
  std::vector<std::unique_ptr<AtomicFile>> trajectories;
  const auto write = [&trajectories](const fs::path& file, const std::string& text) {
    if (file.empty()) return;
    trajectories.push_back(std::make_unique<AtomicFile>(file));
    files::WriteText(*trajectories.back(), text);
  };
  write(params.trajectory, TrajectoryText(frames));
  write(params.tilt.uncompensated, UncompensatedText(frames, view));
  writer.Commit();
  summary.files.push_back(params.output);
  for (const auto& trajectory : trajectories) {
    trajectory->Commit();
    summary.files.push_back(trajectory->Target());
  }
  if (!params.image.empty()) {
    store::ExportPng(store::MapReader(params.output), params.image);
    summary.files.push_back(params.image);
  }
}

void RunMap(MapParams params, const CommonOptions& common, terminal::Summary& summary) {
  const auto start = steady_clock::now();
  params.Resolve();
  const std::optional<calib::Rig> rig =
      params.rig.empty() ? std::nullopt : std::optional(calib::ReadRig(params.rig));
  recordings::FrameSource source(params.up, {.stamps = params.stamps});
  const calib::CeilingView view = MakeView(rig, params, source);
  const std::unique_ptr<recordings::TiltSource> tilt =
      recordings::TiltSource::Make(params.tilt, rig, params.rig, params.stamps);
  const std::unique_ptr<recordings::HeadingSource> heading =
      recordings::HeadingSource::Make(params.heading, rig, params.rig, params.stamps);

  const store::MapMetadata metadata = Describe(rig, view, params, common);
  mapping::MapperParams mapper_params;
  mapper_params.origin = params.T_map_first;
  mapper_params.mosaic.resolution = metadata.resolution;
  std::optional<reports::Appending> appending;
  if (params.append) {
    appending.emplace(params.output, metadata, params.resolution);
    mapper_params.first_keyframe_id = appending->NextKeyframeId();
  }
  store::MapWriter writer(params.output, appending ? appending->Metadata() : metadata);
  if (appending) appending->CheckCurrent();
  mapping::Mapper mapper(view, writer, metadata, mapper_params);

  page::PageData page;
  page.title = fmt::format("Map {}", params.output.filename().string());
  page.unit = metadata.unit;
  live::RunWatch watch(params.watch, params.up, std::move(page), view);
  MapFrames(source, tilt.get(), heading.get(), mapper, watch);
  for (const std::string& warning : source.Warnings()) terminal::PrintWarning(warning);
  if (tilt) {
    for (const std::string& warning : tilt->Warnings()) terminal::PrintWarning(warning);
  }
  if (heading) {
    for (const std::string& warning : heading->Warnings()) terminal::PrintWarning(warning);
  }
  if (terminal::Interrupted()) ReportInterrupted(mapper);
  reports::MapResult result;
  if (appending) {
    result = appending->Finish(params.up, view, mapper, writer);
  } else {
    FinishMap(mapper);
    result = {nullptr, nullptr, mapper.Trajectory(), mapper.Report(), mapper.Graph().weak_spots};
  }
  result.tilt = tilt.get();
  result.heading = heading.get();
  CommitFiles(result.frames, view, writer, params, summary);
  ReportAssumptions(rig.has_value(), source.Stamps());

  const terminal::Table facts =
      reports::FactsOf(result, metadata.unit, terminal::SecondsSince(start));
  reports::Summarize(result, source.Report(), metadata.unit, summary);
  reports::WarnOfParts(result);
  if (!common.quiet) reports::PrintFacts(facts, summary);
  if (!watch.Wanted()) return;
  watch.Replace(result.frames);
  watch.End(store::MapReader(params.output), facts, common.quiet, summary);
}

}  // namespace

Command AddMapCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "map",
      "Makes a map of the ceiling, and the robot's trajectory, from a recording.",
      "ceilmap map --rig rig.yaml --up up.mp4 --stamps frames.csv -o lab.gpkg --trajectory "
      "lab.tum\n"
      "A SOURCE is a video file, a folder or printf pattern of images, /dev/videoN, or a URL.");
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
  add("--picture", params->image, "The mosaic as seen from above", "FILE.png")->group(result);
  params->watch.AddTo(cli, result);
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunMap(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
