#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "app/commands/commands.hpp"
#include "app/commands/compass_options.hpp"
#include "app/commands/heading_inputs.hpp"
#include "app/commands/settings_options.hpp"
#include "app/commands/wheel_options.hpp"
#include "app/figures/figure.hpp"
#include "app/figures/heading_figures.hpp"
#include "app/files/heading_csv.hpp"
#include "app/files/output_files.hpp"
#include "app/files/tum.hpp"
#include "app/recordings/compass_frames.hpp"
#include "app/recordings/panorama_source.hpp"
#include "app/recordings/wheel_inputs.hpp"
#include "app/reports/heading_report.hpp"
#include "app/reports/wheel_report.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/interrupt.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "localization/compass/wheel_turns.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using std::chrono::steady_clock;

struct HeadingOptions {
  recordings::PanoramaOptions panorama;
  fs::path travel;
  fs::path tilt;
  WheelOptions wheels;
  CompassOptions compass;
  fs::path output;
  fs::path truth;
  fs::path plot;
  std::optional<std::int64_t> plot_frame;
  SettingsOptions settings;

  // Wheels and gyro may be in the bag of the images. @throws InputError
  void TakeBag();
  // Checks everything that can be checked without the recording. @throws InputError
  void Check(files::Existing existing) const;
};

void HeadingOptions::TakeBag() {
  panorama.bags.CheckMain("omni", panorama.Source());
  wheels.TakeBag(panorama.bags, panorama.omni.empty() ? "panorama" : "omni", panorama.Source());
}

void HeadingOptions::Check(files::Existing existing) const {
  panorama.Check();
  if (!tilt.empty() && panorama.rig.empty()) {
    throw InputError(
        "--tilt: needs --rig with the mirror's shape, by which a tilt can be taken out");
  }
  compass.Check();
  if (plot_frame && plot.empty()) {
    throw InputError("--plot-frame: the figure is written to --plot DIR; give that too");
  }
  if (plot_frame && *plot_frame < 1) {
    throw InputError(fmt::format(
        "--plot-frame {}: must be at least 1; frame 0 has no earlier reference", *plot_frame));
  }
  if (wheels.Given() && compass.method != "fft") {
    throw InputError(fmt::format("{}: --method {} uses panoramas alone; leave one of the two out",
                                 wheels.odometry.empty() ? "--gyro" : "--odometry",
                                 compass.method));
  }
  wheels.CheckRigOut(!panorama.rig.empty());
  std::error_code ignored;
  for (const fs::path& target : {output, wheels.rig_out}) {
    for (const fs::path& source : {panorama.rig,
                                   panorama.stamps,
                                   travel,
                                   tilt,
                                   wheels.odometry,
                                   wheels.gyro,
                                   truth,
                                   fs::path(panorama.Source())}) {
      if (target.empty() || source.empty() || !fs::equivalent(target, source, ignored)) continue;
      throw InputError(
          fmt::format("{}: is read by this run and cannot be its result too", target.string()));
    }
  }
  files::CheckOutputFiles({output, wheels.rig_out}, existing);
}

// The published methods have a column per degree by default.
recordings::PanoramaOptions ForMethod(recordings::PanoramaOptions options,
                                      const std::string& method) {
  constexpr int kPaperColumns = 360;
  if (!options.omni.empty() && !options.columns && method != "fft") {
    options.columns = kPaperColumns;
  }
  return options;
}

void CheckPlotFrame(const HeadingOptions& params, const recordings::FrameSource& source) {
  const std::optional<std::int64_t> frames = source.ExpectedFrames();
  if (!params.plot_frame || !frames || *params.plot_frame < *frames) return;
  throw InputError(fmt::format("--plot-frame {}: {} has {} frames, 0 to {}",
                               *params.plot_frame,
                               source.Name(),
                               *frames,
                               *frames - 1));
}

// Wheels and gyro of the robot, beside its panoramas.
struct KnownTurns {
  explicit KnownTurns(const HeadingOptions& params, const recordings::PanoramaSource& source)
      : inputs(params.wheels.odometry,
               params.wheels.gyro,
               params.panorama.bags.Topic("odometry"),
               params.panorama.bags.Topic("gyro")),
        wheels(source.Rig() ? source.Rig()->wheels.value_or(wheels::WheelModel{})
                            : wheels::WheelModel{},
               source.Rig() ? source.Rig()->axle_behind_mast_m : 0,
               source.Position()) {}

  void Complete(compass::PanoramaFrame& frame) {
    inputs.ReadTo(frame.stamp_s, [this](const auto& sample) { wheels.Add(sample); });
    wheels.Complete(frame);
  }

  recordings::WheelInputs inputs;
  compass::WheelTurns wheels;
};

// Distances of the frame to be plotted: the requested one, else the last one.
struct PlottedProfile {
  std::int64_t frame = 0;
  compass::DistanceProfile profile;
  cv::Mat panorama;
};

void MeasureFrames(recordings::PanoramaSource& source,
                   compass::Compass& compass,
                   KnownTravel& travel,
                   const recordings::PosesByTime* tilts,
                   KnownTurns& turns,
                   const std::optional<std::int64_t>& plot_frame,
                   reports::HeadingResult& result,
                   PlottedProfile& plotted) {
  terminal::Progress progress("heading", "frames", source.Source().ExpectedFrames());
  recordings::PanoramaSource::TiltAt tilt_at;
  if (tilts != nullptr) {
    tilt_at = [&](double stamp_s) -> std::optional<Tilt> {
      const StampedPose* const pose = tilts->Nearest(stamp_s);
      if (pose == nullptr) return std::nullopt;
      ++result.levelled;
      return recordings::TiltOf(*pose);
    };
  }
  while (source.Read(tilt_at)) {
    const recordings::Frame& frame = source.Raw();
    const auto start = steady_clock::now();
    compass::PanoramaFrame panorama;
    panorama.panorama = source.Panorama();
    panorama.stamp_s = frame.stamp_s;
    panorama.travel = travel.To(frame.stamp_s);
    turns.Complete(panorama);
    const auto estimate = compass.Next(panorama);
    turns.wheels.Learn(frame.stamp_s, estimate);
    result.compass_ms += terminal::MillisecondsSince(start);
    progress.Update(++result.frames);
    if (!estimate) continue;
    result.headings.push_back({frame.index, frame.stamp_s, *estimate});
    if (!(estimate->confidence > 0)) ++(estimate->seen ? result.contradicted : result.held);
    if (plot_frame == frame.index) {
      plotted = {frame.index, compass.Profile(), panorama.panorama.clone()};
    }
    terminal::Detail("frame {} at {:.6f} s: {:.3f} rad, confidence {:.3f}",
                     frame.index,
                     frame.stamp_s,
                     estimate->heading_rad,
                     estimate->confidence);
  }
}

std::optional<evaluation::HeadingErrors> ErrorsAgainst(const std::vector<StampedPose>& truth,
                                                       const HeadingOptions& params,
                                                       const reports::HeadingResult& result) {
  if (truth.empty()) return std::nullopt;
  std::vector<evaluation::StampedHeading> headings;
  headings.reserve(result.headings.size());
  for (const files::MeasuredHeading& heading : result.headings) {
    headings.push_back({heading.stamp_s, heading.estimate.heading_rad});
  }
  std::optional<evaluation::HeadingErrors> errors =
      evaluation::CompareHeadings(headings, truth, kMaxPoseDtS);
  if (!errors) {
    throw InputError(fmt::format(
        "{}: no pose within {} s of a frame of {}; do --stamps and truth use the same clock?",
        params.truth.string(),
        kMaxPoseDtS,
        params.panorama.Source()));
  }
  return errors;
}

void DrawFigures(figures::FigureFolder& folder,
                 const HeadingOptions& params,
                 const reports::HeadingResult& result,
                 const PlottedProfile& plotted) {
  folder.Draw(figures::HeadingFigure(result.headings, result.errors ? &*result.errors : nullptr));
  if (!plotted.profile.distance.empty()) {
    folder.Draw(figures::DistanceFigure(plotted.frame, plotted.profile, plotted.panorama));
  } else if (params.plot_frame) {
    terminal::Warn("--plot-frame {}: the compass did not process that frame", *params.plot_frame);
  }
}

void Report(const recordings::PanoramaSource& source,
            const recordings::PosesByTime* tilts,
            const recordings::WheelInputs& wheels,
            const reports::HeadingResult& result) {
  for (const std::string& warning : source.Source().Warnings()) terminal::PrintWarning(warning);
  for (const std::string& warning :
       reports::WheelWarnings(wheels, result.wheels, reports::kPanoramas)) {
    terminal::PrintWarning(warning);
  }
  if (terminal::Interrupted())
    terminal::PrintNote(fmt::format("interrupted: {} frames were used", result.frames));
  if (source.Scaling()) terminal::PrintNote(source.Scaling()->Text());
  if (source.Source().Stamps() == recordings::StampOrigin::kFrameIndex) {
    terminal::Note("no --stamps: images are taken to be one second apart");
  }
  if (tilts != nullptr && result.levelled < result.frames) {
    terminal::Warn(
        "{} of {} panoramas have no pose within {} s in --tilt: they were taken as level",
        result.frames - result.levelled,
        result.frames,
        recordings::PosesByTime::kMaxDtS);
  }
  if (result.held > 0) {
    terminal::Warn("{} of {} headings were held: the panoramas did not determine them",
                   result.held,
                   result.headings.size());
  }
  if (result.contradicted > 0) {
    terminal::Warn("{} of {} panoramas contradict the known turn and were not used",
                   result.contradicted,
                   result.headings.size());
  }
}

void RunHeading(HeadingOptions params, const CommonOptions& common, terminal::Summary& summary) {
  const auto start = steady_clock::now();
  params.TakeBag();
  params.Check(common.Existing());
  CommandSettings settings = params.settings.Read();
  settings.compass = params.compass.Resolve(settings.compass);
  summary.settings = SettingsJson(settings, {"compass"});
  std::vector<StampedPose> truth;
  if (!params.truth.empty()) truth = files::ReadTum(params.truth);
  std::optional<figures::FigureFolder> figures;
  if (!params.plot.empty()) figures.emplace(params.plot, common.Existing());
  params.wheels.Reserve(params.panorama.bags);
  recordings::PanoramaSource source(ForMethod(params.panorama, params.compass.method));
  CheckPlotFrame(params, source.Source());
  const std::unique_ptr<compass::Compass> compass = labrosse::MakeCompass(settings.compass);

  reports::HeadingResult result;
  PlottedProfile plotted;
  KnownTravel travel(params.travel, source.Position());
  std::optional<recordings::PosesByTime> tilts;
  if (!params.tilt.empty()) tilts.emplace(params.tilt);
  KnownTurns turns(params, source);
  MeasureFrames(source,
                *compass,
                travel,
                tilts ? &*tilts : nullptr,
                turns,
                params.plot_frame,
                result,
                plotted);
  constexpr std::int64_t kMinFrames = 3;  // for the travel to the last one
  if (!params.travel.empty() && travel.Reported() == 0 && result.frames >= kMinFrames) {
    throw InputError(fmt::format("{}: no poses at the times of {}; do the two use the same clock?",
                                 params.travel.string(),
                                 params.panorama.Source()));
  }
  if (tilts && result.levelled == 0) {
    throw InputError(fmt::format("{}: no poses at the times of {}; do the two use the same clock?",
                                 params.tilt.string(),
                                 params.panorama.Source()));
  }
  if (result.headings.empty()) throw RunError("interrupted before the first frame");
  if (figures && !params.plot_frame) {
    plotted = {result.headings.back().frame, compass->Profile(), source.Panorama()};
  }
  result.references = compass->References();
  result.panorama = source.Size();
  result.reading = source.Source().Report();
  result.unwrap_ms = source.UnwrapMs();
  result.wheels = turns.wheels.Report();
  result.errors = ErrorsAgainst(truth, params, result);

  files::WriteFileAtomically(
      params.output,
      files::FormatHeadings(result.headings, result.errors ? &*result.errors : nullptr));
  summary.files.push_back(params.output);
  if (source.Rig()) params.wheels.WriteRig(*source.Rig(), result.wheels, summary);
  Report(source, tilts ? &*tilts : nullptr, turns.inputs, result);
  if (figures) {
    DrawFigures(*figures, params, result, plotted);
    summary.files.insert(summary.files.end(), figures->Files().begin(), figures->Files().end());
  }
  result.seconds = terminal::SecondsSince(start);
  reports::Summarize(result, summary);
  if (!common.quiet) reports::PrintReport(result, summary);
}

}  // namespace

Command AddHeadingCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "heading",
      "Measures the heading of a robot with a camera under a convex mirror (visual compass).",
      "ceilmap heading --rig rig.yaml --omni omni.mp4 --stamps frames.csv -o heading.csv\n"
      "  ceilmap heading --rig rig.yaml --omni omni.mp4 --stamps frames.csv --gyro gyro.csv -o "
      "heading.csv\n"
      "  ceilmap heading --ring 320,240,60,230 --omni omni.avi -o heading.csv --plot figures\n"
      "  ceilmap heading --panorama panoramas --azimuth rising -o heading.csv\n"
      "  ceilmap heading --rig rig.yaml --omni run.mcap --omni-topic /omni/image_raw --gyro-topic "
      "/imu "
      "-o heading.csv\n"
      "A SOURCE is a video file, a folder or printf pattern of images, a bag of ROS, /dev/videoN, "
      "or "
      "a URL.");
  auto params = std::make_shared<HeadingOptions>();
  CLI::App& cli = *command.cli;
  params->panorama.AddTo(cli, "Input", "Unwrapping");
  params->panorama.bags.AddTo(cli, {"omni", "odometry", "gyro"});
  params->compass.AddTo(cli, "Compass");
  params->settings.AddTo(cli);
  cli.add_option("--travel",
                 params->travel,
                 "Poses from odometry or the ceiling, for robots that do not only drive ahead "
                 "and back")
      ->type_name("T.tum")
      ->group("Compass");
  cli.add_option("--tilt",
                 params->tilt,
                 "Poses by 'map' or 'localize': their roll and pitch are taken out of the "
                 "panoramas (uneven ground); needs --rig with the mirror's shape")
      ->type_name("T.tum")
      ->group("Unwrapping");
  const std::string result = "Results";
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type);
  };
  params->wheels.AddTo(cli,
                       "Compass",
                       result,
                       "Turn rates of a gyro, with or without --odometry: timestamp,omega_z");
  add("-o,--output",
      params->output,
      "Counter-clockwise from the first frame: timestamp,heading_deg,sigma_deg,confidence",
      "H.csv")
      ->required()
      ->group(result);
  add("--truth", params->truth, "True poses: errors, also as columns of H.csv", "T.tum")
      ->group(result);
  add("--plot", params->plot, "Folder for figures with their gnuplot scripts and data", "DIR")
      ->group(result);
  add("--plot-frame",
      params->plot_frame,
      "Frame of which the panorama and the distances over all shifts are shown [the last]",
      "N")
      ->group(result);
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunHeading(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
