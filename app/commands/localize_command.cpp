#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>

#include "app/commands/commands.hpp"
#include "app/files/arguments.hpp"
#include "app/files/output_files.hpp"
#include "app/files/status_csv.hpp"
#include "app/files/tum.hpp"
#include "app/live/run_watch.hpp"
#include "app/recordings/frame_source.hpp"
#include "app/recordings/heading_source.hpp"
#include "app/recordings/robot_rig.hpp"
#include "app/recordings/sensor_fusion.hpp"
#include "app/recordings/tilt_source.hpp"
#include "app/reports/localize_report.hpp"
#include "app/reports/page_parts.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "calib/level_view.hpp"
#include "calib/rig.hpp"
#include "localization/localizer.hpp"
#include "mapping/store/map_file.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using std::chrono::steady_clock;

struct LocalizeParams {
  fs::path map;
  fs::path rig;
  std::string up;
  fs::path stamps;
  std::string start;
  std::string start_spread = "0.5,10";
  recordings::HeadingOptions heading;
  std::string heading_zero = "first";
  recordings::TiltOptions tilt;
  fs::path output;
  fs::path status;
  bool stream = false;
  live::WatchOptions watch;

  // Checks everything that can be told without the recording. @throws InputError
  void Check() const;
  [[nodiscard]] localization::LocalizerParams ForLocalizer() const;
};

void LocalizeParams::Check() const {
  heading.Check(true);
  if (heading.Absolute() && heading_zero != "first") {
    throw InputError(
        "--heading-zero: headings of --heading-model count from the map's x axis; leave it out");
  }
  if (!heading.omni.empty() && heading_zero != "first") {
    throw InputError("--heading-zero: headings of --omni count from the first frame; leave it out");
  }
  tilt.Check(true);
  files::CheckOutputFiles({output, tilt.uncompensated, status});
  std::error_code ignored;
  for (const fs::path& target : {output, tilt.uncompensated, status}) {
    for (const fs::path& source : {map, rig, stamps, heading.file, heading.model, fs::path(up)}) {
      if (target.empty() || source.empty() || !fs::equivalent(target, source, ignored)) continue;
      throw InputError(
          fmt::format("{}: is read by this run and cannot be its result too", target.string()));
    }
  }
  watch.Check();
}

localization::LocalizerParams LocalizeParams::ForLocalizer() const {
  localization::LocalizerParams params;
  params.heading.unknown_zero = heading_zero == "first" && !heading.Absolute();
  const files::PoseSpread spread = files::ParseSpread(start_spread, "--start-spread");
  if (!start.empty()) {
    localization::PoseEstimate pose{files::ParsePose2(start, "--start")};
    const double position = spread.position_m * spread.position_m;
    pose.covariance.diagonal() << position, position, spread.yaw_rad * spread.yaw_rad;
    params.start = pose;
  }
  return params;
}

// The files that grow with the run, and what is told as it goes.
class Results {
 public:
  Results(const LocalizeParams& params, const calib::LevelView& level)
      : level_(level),
        trajectory_(params.output),
        uncompensated_(params.tilt.uncompensated),
        status_(params.status),
        stream_(params.stream) {
    for (files::GrowingFile* file : {&trajectory_, &uncompensated_})
      file->Append(files::TumHeader());
    status_.Append(files::StatusHeader());
  }

  void Add(const localization::Location& location) {
    status_.Append(files::FormatStatusLine(location));
    if (!location.Placed()) return;
    const graph::FramePose& pose = location.pose;
    const std::string line =
        files::FormatTumLine(ToStampedPose(pose.stamp_s, pose.T_map_base, pose.tilt));
    trajectory_.Append(line);
    uncompensated_.Append(files::FormatTumLine(
        ToStampedPose(pose.stamp_s, level_.Uncompensated(pose.T_map_base, pose.tilt))));
    if (!stream_) return;
    fmt::print("{}", line);
    std::fflush(stdout);
  }

  void CommitStatus() { status_.Commit(); }
  void Commit(const LocalizeParams& params, terminal::Summary& summary) {
    for (files::GrowingFile* file : {&trajectory_, &uncompensated_, &status_}) file->Commit();
    for (const fs::path& file : {params.output, params.tilt.uncompensated, params.status}) {
      if (!file.empty()) summary.files.push_back(file);
    }
  }

 private:
  calib::LevelView level_;
  files::GrowingFile trajectory_;
  files::GrowingFile uncompensated_;
  files::GrowingFile status_;
  bool stream_;
};

// Sums over the frames.
class Tally {
 public:
  void Add(const localization::Location& location, bool live, reports::LocalizeResult& result) {
    const graph::FramePose& pose = location.pose;
    if (!first_stamp_s_) first_stamp_s_ = pose.stamp_s;
    if (live) {
      const double latency_ms = 1e3 * (terminal::ClockSeconds() - pose.stamp_s);
      result.latency_ms = std::max(latency_ms, result.latency_ms.value_or(0));
    }
    if (!location.Placed()) {
      had_pose_ = false;
      return;
    }
    if (!result.first_placed_s) {
      result.first_placed_s = pose.stamp_s - *first_stamp_s_;
      result.first_placed_frame = pose.frame_index;
    }
    if (had_pose_) result.path_m += (pose.T_map_base.Translation() - last_.Translation()).norm();
    had_pose_ = true;
    last_ = pose.T_map_base;
    variances_ += 0.5 * (pose.covariance(0, 0) + pose.covariance(1, 1));
    ++placed_;
    result.mean_sigma_m = std::sqrt(variances_ / static_cast<double>(placed_));
  }

 private:
  std::optional<double> first_stamp_s_;
  bool had_pose_ = false;  // in the frame before
  Pose2 last_;
  double variances_ = 0;
  std::int64_t placed_ = 0;
};

void LocateFrames(recordings::FrameSource& source,
                  recordings::TiltSource* tilt,
                  recordings::HeadingSource* heading,
                  localization::Localizer& localizer,
                  Results& results,
                  live::RunWatch& watch,
                  reports::LocalizeResult& result) {
  terminal::Progress progress("localizing", "frames", source.ExpectedFrames());
  const bool live = source.Stamps() == recordings::StampOrigin::kClock;
  recordings::SensorFusion frames(source, tilt, heading);
  recordings::MeasuredFrame measured;
  Tally tally;
  std::int64_t done = 0;
  while (frames.Read(measured)) {
    const recordings::Frame& frame = measured.frame;
    const localization::Location location = localizer.Locate(
        {frame.image, frame.index, frame.stamp_s, measured.context.heading, measured.context.tilt});
    if (location.tilt_left) frames.Correct(*location.tilt_left);
    frames.Locate(location.Placed() ? std::optional(location.pose.T_map_base) : std::nullopt);
    results.Add(location);
    tally.Add(location, live, result);
    watch.Add(location.pose, source.ExpectedFrames());
    progress.Update(++done);
    terminal::Detail("frame {} at {:.6f} s: {}",
                     frame.index,
                     frame.stamp_s,
                     graph::ToString(location.pose.status));
  }
}

// A recording of another room, or nothing to see: no pose, and why.
[[noreturn]] void ReportNothingFound(const LocalizeParams& params,
                                     const reports::LocalizeResult& result) {
  const localization::LocalizerReport& report = result.report;
  if (terminal::Interrupted()) {
    throw RunError(
        fmt::format("interrupted after {} frames, before any could be placed", report.frames));
  }
  const char* const reason =
      report.ambiguous > report.lost
          ? "several places of the map look alike; drive farther, or give --start or --heading"
          : "nothing on the map looks like it; is it the map of this place, and the rig of this "
            "robot?";
  throw RunError(fmt::format("{}: none of its {} frames could be placed on {}: {}",
                             params.up,
                             report.frames,
                             params.map.string(),
                             reason));
}

// Where rig and map do not agree; the map's word counts.
void WarnOfScale(const calib::Rig& rig,
                 const store::MapMetadata& map,
                 const reports::LocalizeResult& result) {
  constexpr double kNotable = 0.01;
  if (std::abs(rig.ceiling_height_m / map.ceiling_height_m - 1) > kNotable) {
    terminal::Warn(
        "the rig says that the ceiling is at {} m, the map says {} m: the map's height is used",
        rig.ceiling_height_m,
        map.ceiling_height_m);
  }
  const double scale = result.report.scale.value_or(1);
  if (std::abs(scale - 1) > kNotable) {
    terminal::Warn(
        "the ceiling looks {:.1f} % {} than the rig says; check the camera's height and focal "
        "length",
        100 * std::abs(scale - 1),
        scale > 1 ? "larger" : "smaller");
  }
}

// What the live page has from the beginning: the map.
page::PageData StartOfPage(const LocalizeParams& params, const store::MapReader& map) {
  page::PageData page;
  page.title = fmt::format(
      "{} on {}", fs::path(params.up).filename().string(), params.map.filename().string());
  if (params.watch.Live()) reports::AddMap(map, page);
  return page;
}

void RunLocalize(const LocalizeParams& params,
                 const CommonOptions& common,
                 terminal::Summary& summary) {
  const auto start = steady_clock::now();
  params.Check();
  const localization::LocalizerParams localizer_params = params.ForLocalizer();
  const calib::Rig rig = calib::ReadRig(params.rig);
  const store::MapReader map(params.map);
  recordings::FrameSource source(params.up, {.stamps = params.stamps, .live_queue = 1});
  const calib::MountedCamera& up = recordings::UpCameraOf(rig, params.rig, source);
  localization::Localizer localizer = [&] {
    try {
      return localization::Localizer(map, up, localizer_params);
    } catch (const InputError& error) {
      throw InputError(
          fmt::format("{} on {}: {}", params.rig.string(), params.map.string(), error.what()));
    }
  }();

  const std::unique_ptr<recordings::TiltSource> tilt =
      recordings::TiltSource::Make(params.tilt, rig, params.rig, params.stamps);
  const std::unique_ptr<recordings::HeadingSource> heading =
      recordings::HeadingSource::Make(params.heading, rig, params.rig, params.stamps);
  reports::LocalizeResult result;
  result.tilt = tilt.get();
  result.heading = heading.get();
  const calib::CeilingView view(up, map.Metadata().ceiling_height_m);
  Results results(params, calib::LevelView(view));
  live::RunWatch watch(params.watch, params.up, StartOfPage(params, map), view);
  LocateFrames(source, tilt.get(), heading.get(), localizer, results, watch, result);
  for (const std::string& warning : source.Warnings()) terminal::PrintWarning(warning);
  if (tilt) {
    for (const std::string& warning : tilt->Warnings()) terminal::PrintWarning(warning);
  }
  if (heading) {
    for (const std::string& warning : heading->Warnings()) terminal::PrintWarning(warning);
  }
  result.report = localizer.Report();
  result.reading = source.Report();
  result.seconds = terminal::SecondsSince(start);
  if (result.Placed() == 0) {
    results.CommitStatus();  // it tells why
    ReportNothingFound(params, result);
  }
  results.Commit(params, summary);
  if (terminal::Interrupted()) {
    terminal::PrintNote(fmt::format("interrupted: {} frames were located", result.report.frames));
  }
  if (source.Stamps() == recordings::StampOrigin::kFrameIndex) {
    terminal::Note("no --stamps: images are taken to be one second apart");
  }
  WarnOfScale(rig, map.Metadata(), result);
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
      "Finds a robot on a map of the ceiling, wherever it is switched on, and follows it.",
      "ceilmap localize lab.gpkg --rig rig2.yaml --up up2.mp4 --stamps frames2.csv -o robot2.tum\n"
      "A SOURCE is a video file, a folder or printf pattern of images, /dev/videoN, or a URL.");
  auto params = std::make_shared<LocalizeParams>();
  CLI::App& cli = *command.cli;
  const std::string input = "Input";
  const std::string prior = "What is known";
  const std::string result = "Results";
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  add("map", params->map, "The map, made with --rig", "MAP.gpkg")->required()->group(input);
  add("--rig", params->rig, "This robot's cameras", "RIG.yaml")->required()->group(input);
  add("--up", params->up, "Upward camera", "SOURCE")->required()->group(input);
  add("--stamps", params->stamps, "Time of each frame: index,timestamp", "FRAMES.csv")
      ->group(input);
  add("--start", params->start, "Pose of the first frame [anywhere on the map]", "X,Y,YAW_DEG")
      ->group(prior);
  add("--start-spread", params->start_spread, "Standard deviations of --start", "M,DEG")
      ->capture_default_str()
      ->group(prior);
  params->heading.AddTo(cli, input, prior);
  params->heading.AddModelTo(cli, prior);
  add("--heading-zero",
      params->heading_zero,
      "Where headings count from: the first frame (or any other unknown direction), or the map's x "
      "axis",
      "ZERO")
      ->check(CLI::IsMember({"first", "map"}))
      ->capture_default_str()
      ->group(prior);
  add("-o,--output", params->output, "Poses of all frames found", "T.tum")
      ->required()
      ->group(result);
  params->tilt.AddTo(cli, input, result);
  add("--status", params->status, "What is known of every frame, and how well", "S.csv")
      ->group(result);
  cli.add_flag("--stream", params->stream, "Poses to stdout as they are found, instead of a report")
      ->group(result);
  params->watch.AddTo(cli, result);
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    params->heading.forward = params->tilt.forward;
    params->heading.forward_stamps = params->tilt.forward_stamps;
    RunLocalize(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
