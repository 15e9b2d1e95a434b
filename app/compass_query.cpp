#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "app/clock.hpp"
#include "app/colour_model_file.hpp"
#include "app/compass_commands.hpp"
#include "app/compass_frames.hpp"
#include "app/compass_report.hpp"
#include "app/console.hpp"
#include "app/figure.hpp"
#include "app/heading_figures.hpp"
#include "app/output_files.hpp"
#include "app/progress.hpp"
#include "calib/base/error.hpp"
#include "localization/compass/colour/colour_compass.hpp"

namespace fs = std::filesystem;

namespace ceilmap::app {
namespace {

using std::chrono::steady_clock;

constexpr double kTruthDtS = 0.02;  // between a heading and its true pose

struct QueryParams {
  fs::path model;
  ForwardOptions forward;
  fs::path poses;
  colour::ScanLineParams lines = {};
  bool no_parallax = false;
  bool update = false;
  fs::path save;
  fs::path output;
  fs::path truth;
  fs::path plot;

  // Checks everything that can be told without the recording. @throws InputError
  void Check() const;
  [[nodiscard]] colour::ColourCompassParams Settings() const;
};

void QueryParams::Check() const {
  if (update && poses.empty()) {
    throw InputError("--update: what is seen is learned at a place; give --poses too");
  }
  if (!save.empty() && !update) {
    throw InputError("--save: nothing is learned without --update; give that too");
  }
  CheckOutputFiles({output, save});
  for (const fs::path& result : {output, save}) {
    forward.CheckResult(result);
    CheckNotRead(result, {poses, truth});
  }
  CheckNotRead(output, {model});
}

colour::ColourCompassParams QueryParams::Settings() const {
  colour::ColourCompassParams settings;
  settings.lines = lines;
  settings.parallax = !no_parallax;
  settings.Validate();
  return settings;
}

compass::HeadingEstimate EstimateOf(const colour::ColourHeading& heading) {
  return {heading.heading_rad, heading.variance_rad2, heading.confidence};
}

// A heading that may be another one would spoil the model.
bool LearnAlong(const colour::ColourHeading& heading,
                const StampedPose& pose,
                colour::ColourCompass& compass) {
  if (heading.confidence < kSureConfidence) return false;
  colour::LearnedPose learned;
  learned.T_map_base = {pose.position.x(), pose.position.y(), heading.heading_rad};
  learned.tilt = TiltOf(pose);
  learned.sigma_rad = std::max(learned.sigma_rad, std::sqrt(heading.variance_rad2));
  compass.Learn(learned);
  return true;
}

std::optional<colour::ColourHeading> Ask(const Frame& frame,
                                         const StampedPose* pose,
                                         colour::ColourCompass& compass) {
  colour::ColourFrame seen;
  seen.bgr = frame.picture;
  seen.stamp_s = frame.stamp_s;
  colour::PlaceHypothesis place;
  if (pose != nullptr) {
    place.place = pose->position.head<2>();
    seen.places = {&place, 1};
    seen.tilt = TiltOf(*pose);
  }
  return compass.Next(seen);
}

void TellDetail(const Frame& frame, const std::optional<colour::ColourHeading>& heading) {
  if (heading) {
    Detail("frame {} at {:.6f} s: {:.3f} rad, sigma {:.3f}, confidence {:.3f}",
           frame.index,
           frame.stamp_s,
           heading->heading_rad,
           std::sqrt(heading->variance_rad2),
           heading->confidence);
  } else {
    Detail(
        "frame {} at {:.6f} s: skipped, too little above the horizon", frame.index, frame.stamp_s);
  }
}

CompassQueryResult AskFrames(ForwardFrames& frames,
                             const PosesByTime* poses,
                             bool update,
                             colour::ColourCompass& compass) {
  CompassQueryResult result;
  Progress progress("heading", "frames", frames.Source().ExpectedFrames());
  while (frames.Read()) {
    progress.Update(frames.Count());
    const Frame& frame = frames.Current();
    const StampedPose* const pose = poses != nullptr ? poses->Nearest(frame.stamp_s) : nullptr;
    if (poses != nullptr && pose == nullptr) ++result.unused.without_pose;
    const auto start = steady_clock::now();
    const std::optional<colour::ColourHeading> heading = Ask(frame, pose, compass);
    if (heading && update && pose != nullptr && LearnAlong(*heading, *pose, compass)) {
      ++result.learned;
    }
    result.compass_ms += MillisecondsSince(start);
    if (heading) result.headings.push_back({frame.index, frame.stamp_s, EstimateOf(*heading)});
    TellDetail(frame, heading);
  }
  result.frames = frames.Count();
  result.unused.below_horizon = compass.Counts().below_horizon;
  result.without_turn = compass.Counts().without_turn;
  result.reading = frames.Source().Report();
  return result;
}

std::optional<evaluation::HeadingErrors> ErrorsAgainst(const std::vector<StampedPose>& truth,
                                                       const QueryParams& params,
                                                       const CompassQueryResult& result) {
  if (truth.empty()) return std::nullopt;
  std::vector<evaluation::StampedHeading> headings;
  headings.reserve(result.headings.size());
  for (const MeasuredHeading& heading : result.headings) {
    headings.push_back({heading.stamp_s, heading.estimate.heading_rad});
  }
  auto errors =
      evaluation::CompareHeadings(headings, truth, kTruthDtS, evaluation::HeadingZero::kTruth);
  if (!errors) {
    throw InputError(
        fmt::format("{}: no pose within {} s of a frame of {}; do --stamps and truth count alike?",
                    params.truth.string(),
                    kTruthDtS,
                    params.forward.forward));
  }
  return errors;
}

void Store(const QueryParams& params,
           const CommonOptions& common,
           const CompassQueryResult& result,
           const colour::ColourCompass& compass,
           Summary& summary) {
  const evaluation::HeadingErrors* const errors = result.errors ? &*result.errors : nullptr;
  WriteFileAtomically(params.output, FormatHeadings(result.headings, errors));
  summary.files.push_back(params.output);
  if (params.save.empty()) return;
  colour::ColourModel model = compass.Model();
  model.provenance += (model.provenance.empty() ? "" : "\n") + common.command_line;
  WriteColourModel(model, params.save);
  summary.files.push_back(params.save);
}

void Draw(FigureFolder& folder, const CompassQueryResult& result, Summary& summary) {
  folder.Draw(HeadingFigure(result.headings, result.errors ? &*result.errors : nullptr));
  summary.files.insert(summary.files.end(), folder.Files().begin(), folder.Files().end());
}

void RunQuery(const QueryParams& params, const CommonOptions& common, Summary& summary) {
  const auto start = steady_clock::now();
  params.Check();
  colour::ColourCompassParams settings = params.Settings();
  std::vector<StampedPose> truth;
  if (!params.truth.empty()) truth = ReadTum(params.truth);
  std::optional<PosesByTime> poses;
  if (!params.poses.empty()) poses.emplace(params.poses);
  std::optional<FigureFolder> figures;
  if (!params.plot.empty()) figures.emplace(params.plot);
  colour::ColourModel model = ReadColourModel(params.model);
  ForwardFrames frames(params.forward);
  settings.camera_ahead_of_axle_m = frames.AheadOfAxleM();
  colour::ColourCompass compass(std::move(model), frames.Camera(), settings);

  CompassQueryResult result = AskFrames(frames, poses ? &*poses : nullptr, params.update, compass);
  if (poses && result.frames > 0 && result.unused.without_pose == result.frames) {
    RefuseRecording(frames, result.unused, params.poses);
  }
  if (result.headings.empty()) RefuseRecording(frames, result.unused, {});
  result.errors = ErrorsAgainst(truth, params, result);
  Store(params, common, result, compass, summary);
  TellOfFrames(frames, result.unused);
  if (figures) Draw(*figures, result, summary);
  result.seconds = SecondsSince(start);
  Summarize(result, summary);
  if (!common.quiet) PrintReport(result, summary);
}

void AddCompassOptions(CLI::App& cli, QueryParams& params) {
  const std::string group = "Compass";
  cli.add_option("--poses",
                 params.poses,
                 "Where the robot is, if that is known: place, pitch and roll; yaw is not used")
      ->type_name("T.tum")
      ->group("Input");
  AddLineOptions(cli, params.lines, group);
  cli.add_flag("--no-parallax",
               params.no_parallax,
               "As published: all that is seen is taken to be infinitely far")
      ->group(group);
  cli.add_flag("--update",
               params.update,
               "The model learns on the way, at the places of --poses, by its own headings")
      ->group(group);
}

}  // namespace

Command AddCompassQueryCommand(CLI::App& compass) {
  Command command = MakeCommand(
      compass,
      "query",
      "Finds the heading of a robot by a model of the colours around it.",
      "ceilmap compass query lab.colours --rig rig.yaml --forward again.mp4 --stamps again.csv -o "
      "heading.csv\n"
      "  ceilmap compass query lab.colours --rig rig.yaml --forward again.mp4 --truth truth.tum "
      "--plot figures -o heading.csv\n"
      "A SOURCE is a video file, a folder or printf pattern of pictures, /dev/videoN, or a URL.");
  auto params = std::make_shared<QueryParams>();
  CLI::App& cli = *command.cli;
  cli.add_option("model", params->model, "What 'compass learn' made")
      ->required()
      ->type_name("MODEL");
  params->forward.AddTo(cli, "Input");
  AddCompassOptions(cli, *params);
  const auto add = [&cli](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type)->group("Results");
  };
  add("-o,--output",
      params->output,
      "In the frame of the learned poses: timestamp,heading_deg,sigma_deg,confidence",
      "H.csv")
      ->required();
  add("--save", params->save, "The model as it is after --update", "MODEL2");
  add("--truth", params->truth, "True poses: errors, also as columns of H.csv", "T.tum");
  add("--plot", params->plot, "Figure with its gnuplot script and data", "DIR");
  command.run = [params](const CommonOptions& common, Summary& summary) {
    RunQuery(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::app
