#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/commands/compass_commands.hpp"
#include "app/commands/settings_options.hpp"
#include "app/figures/figure.hpp"
#include "app/figures/heading_figures.hpp"
#include "app/files/output_files.hpp"
#include "app/recordings/compass_frames.hpp"
#include "app/reports/compass_report.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "localization/compass/colour/colour_compass.hpp"
#include "localization/compass/colour/colour_model_file.hpp"
#include "localization/compass/colour/colour_query.hpp"
#include "localization/compass/colour/victoria2013_compass.hpp"
#include "localization/compass/colour/white_balance.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using std::chrono::steady_clock;

constexpr const char* kPrinted = "victoria-2013";
constexpr double kTruthDtS = 0.02;  // between a heading and its true pose

struct QueryOptions {
  fs::path model;
  recordings::ForwardOptions forward;
  fs::path poses;
  fs::path hypotheses;
  colour::ScanLineParams lines = {};
  std::string method;    // empty: that of the model
  std::string previous;  // empty: turned
  bool no_parallax = false;
  bool white_balance = false;
  bool update = false;
  fs::path save;
  fs::path output;
  fs::path truth;
  fs::path plot;
  SettingsOptions settings;

  // Checks everything that can be checked without the recording. @throws InputError
  void Check(files::Existing existing) const;
  // The settings file, with the options that are given.
  [[nodiscard]] CommandSettings ResolveSettings(const CLI::App& cli) const;
};

void QueryOptions::Check(files::Existing existing) const {
  if (update && poses.empty()) {
    throw InputError("--update: learning needs the position of the robot; give --poses too");
  }
  if (!save.empty() && !update) {
    throw InputError("--save: the model only changes with --update; give that too");
  }
  for (const fs::path& result : {output, save}) {
    forward.CheckResult(result);
    recordings::CheckNotRead(result, {poses, hypotheses, truth});
  }
  recordings::CheckNotRead(output, {model});
  files::CheckOutputFiles({output, save}, existing);
}

CommandSettings QueryOptions::ResolveSettings(const CLI::App& cli) const {
  CommandSettings resolved = settings.Read();
  colour::ColourCompassParams& compass = resolved.colour_compass;
  recordings::TakeLineOptions(cli, lines, compass.lines);
  if (no_parallax) compass.parallax = false;
  compass.Validate();
  return resolved;
}

std::unique_ptr<colour::ColourQuery> MakeQuery(const QueryOptions& options,
                                               colour::ColourModel model,
                                               const calib::MountedCamera& forward,
                                               const colour::ColourCompassParams& settings) {
  const bool printed = options.method.empty() ? model.kind == colour::ModelKind::kVictoria2013
                                              : options.method == kPrinted;
  if (printed && options.no_parallax) {
    throw InputError(
        "--no-parallax: is an option of --method bayes; victoria-2013 has no parallax");
  }
  if (!printed && !options.previous.empty()) {
    throw InputError("--previous: is an option of --method victoria-2013; give that too");
  }
  if (!printed) {
    return std::make_unique<colour::ColourCompass>(std::move(model), forward, settings);
  }
  auto previous = colour::PreviousHeading::kTurned;
  if (options.previous == "none") previous = colour::PreviousHeading::kNone;
  if (options.previous == "held") previous = colour::PreviousHeading::kHeld;
  return std::make_unique<colour::Victoria2013Compass>(
      std::move(model), forward, settings, previous);
}

compass::HeadingEstimate EstimateOf(const colour::ColourHeading& heading) {
  return {heading.heading_rad, heading.variance_rad2, heading.confidence};
}

// A heading that is not unique would corrupt the model.
bool LearnAlong(const colour::ColourHeading& heading,
                const StampedPose& pose,
                colour::ColourQuery& compass) {
  if (heading.confidence < reports::kUniqueConfidence) return false;
  colour::LearnedPose learned;
  learned.T_map_base = {pose.position.x(), pose.position.y(), heading.heading_rad};
  learned.tilt = recordings::TiltOf(pose);
  learned.sigma_rad = std::max(learned.sigma_rad, std::sqrt(heading.variance_rad2));
  compass.Learn(learned);
  return true;
}

// What is known of the robot's places.
struct Known {
  std::optional<recordings::PosesByTime> poses;
  std::optional<recordings::HypothesesByTime> hypotheses;
};

// A pose is preferred to hypotheses of the same time.
std::optional<colour::ColourHeading> Ask(const recordings::Frame& frame,
                                         const StampedPose* pose,
                                         const files::StampedHypotheses* hypotheses,
                                         colour::ColourQuery& compass) {
  colour::ColourFrame seen;
  seen.bgr = frame.image;
  seen.stamp_s = frame.stamp_s;
  std::vector<colour::PlaceHypothesis> places;
  if (pose != nullptr) {
    places.push_back({pose->position.head<2>()});
    seen.tilt = recordings::TiltOf(*pose);
  } else if (hypotheses != nullptr) {
    for (const WeightedPose& place : hypotheses->places) {
      places.push_back({place.pose.Translation(), place.weight});
    }
  }
  seen.places = places;
  return compass.Next(seen);
}

void ReportDetail(const recordings::Frame& frame,
                  const std::optional<colour::ColourHeading>& heading) {
  if (heading) {
    terminal::Detail("frame {} at {:.6f} s: {:.3f} rad, sigma {:.3f}, confidence {:.3f}",
                     frame.index,
                     frame.stamp_s,
                     heading->heading_rad,
                     std::sqrt(heading->variance_rad2),
                     heading->confidence);
  } else {
    terminal::Detail(
        "frame {} at {:.6f} s: skipped, too little above the horizon", frame.index, frame.stamp_s);
  }
}

// Reads the whole recording for its mean colour.
colour::ChannelGains MeasureWhiteBalance(const QueryOptions& params,
                                         const Known& known,
                                         const colour::ScanLineParams& line_params,
                                         const colour::ColourModel& model) {
  recordings::ForwardFrames frames(params.forward);
  if (frames.Source().IsLive()) {
    throw InputError("--white-balance: reads the recording twice; give a file or a folder");
  }
  colour::WhiteBalance balance(model.classes);
  colour::ScanLinesByTilt lines_by_tilt(frames.Camera(), line_params);
  cv::Mat samples;
  terminal::Progress progress("white balance", "frames", frames.Source().ExpectedFrames());
  while (frames.Read()) {
    progress.Update(frames.Count());
    const StampedPose* const pose =
        known.poses ? known.poses->Nearest(frames.Current().stamp_s) : nullptr;
    const Tilt tilt = pose != nullptr ? recordings::TiltOf(*pose) : Tilt{};
    const colour::ScanLines& lines = *lines_by_tilt.For(tilt);
    if (!lines.Usable()) continue;
    lines.Sample(frames.Current().image, samples);
    balance.Add(samples, lines);
  }
  return balance.Gains();
}

reports::CompassQueryResult AskFrames(recordings::ForwardFrames& frames,
                                      const Known& known,
                                      const std::optional<colour::ChannelGains>& gains,
                                      bool update,
                                      colour::ColourQuery& compass) {
  reports::CompassQueryResult result;
  result.gains = gains;
  terminal::Progress progress("heading", "frames", frames.Source().ExpectedFrames());
  while (frames.Read()) {
    progress.Update(frames.Count());
    recordings::Frame frame = frames.Current();
    const StampedPose* const pose = known.poses ? known.poses->Nearest(frame.stamp_s) : nullptr;
    const files::StampedHypotheses* const hypotheses =
        known.hypotheses ? known.hypotheses->Nearest(frame.stamp_s) : nullptr;
    const bool expected = known.poses || known.hypotheses;
    if (expected && pose == nullptr && hypotheses == nullptr) ++result.unused.without_pose;
    const auto start = steady_clock::now();
    if (gains) {
      frame.image = frame.image.clone();
      colour::Apply(*gains, frame.image);
    }
    const std::optional<colour::ColourHeading> heading = Ask(frame, pose, hypotheses, compass);
    if (heading && update && pose != nullptr && LearnAlong(*heading, *pose, compass)) {
      ++result.learned;
    }
    result.compass_ms += terminal::MillisecondsSince(start);
    if (heading) result.headings.push_back({frame.index, frame.stamp_s, EstimateOf(*heading)});
    ReportDetail(frame, heading);
  }
  result.frames = frames.Count();
  result.unused.below_horizon = compass.Counts().below_horizon;
  result.without_turn = compass.Counts().without_turn;
  result.reading = frames.Source().Report();
  return result;
}

std::optional<evaluation::HeadingErrors> ErrorsAgainst(const std::vector<StampedPose>& truth,
                                                       const QueryOptions& params,
                                                       const reports::CompassQueryResult& result) {
  if (truth.empty()) return std::nullopt;
  std::vector<evaluation::StampedHeading> headings;
  headings.reserve(result.headings.size());
  for (const files::MeasuredHeading& heading : result.headings) {
    headings.push_back({heading.stamp_s, heading.estimate.heading_rad});
  }
  auto errors =
      evaluation::CompareHeadings(headings, truth, kTruthDtS, evaluation::HeadingZero::kTruth);
  if (!errors) {
    throw InputError(fmt::format(
        "{}: no pose within {} s of a frame of {}; do --stamps and truth use the same clock?",
        params.truth.string(),
        kTruthDtS,
        params.forward.forward));
  }
  return errors;
}

void Store(const QueryOptions& params,
           const CommonOptions& common,
           const reports::CompassQueryResult& result,
           const colour::ColourQuery& compass,
           terminal::Summary& summary) {
  const evaluation::HeadingErrors* const errors = result.errors ? &*result.errors : nullptr;
  files::WriteFileAtomically(params.output, files::FormatHeadings(result.headings, errors));
  summary.files.push_back(params.output);
  if (params.save.empty()) return;
  colour::ColourModel model = compass.Model();
  model.provenance += (model.provenance.empty() ? "" : "\n") + common.command_line;
  colour::WriteColourModel(model, params.save);
  summary.files.push_back(params.save);
}

void Draw(figures::FigureFolder& folder,
          const reports::CompassQueryResult& result,
          terminal::Summary& summary) {
  folder.Draw(figures::HeadingFigure(result.headings, result.errors ? &*result.errors : nullptr));
  summary.files.insert(summary.files.end(), folder.Files().begin(), folder.Files().end());
}

void RunQuery(const QueryOptions& params,
              const CLI::App& cli,
              const CommonOptions& common,
              terminal::Summary& summary) {
  const auto start = steady_clock::now();
  params.Check(common.Existing());
  CommandSettings resolved = params.ResolveSettings(cli);
  colour::ColourCompassParams& settings = resolved.colour_compass;
  summary.settings = SettingsJson(resolved, {"colour_compass"});
  std::vector<StampedPose> truth;
  if (!params.truth.empty()) truth = files::ReadTum(params.truth);
  Known known;
  if (!params.poses.empty()) known.poses.emplace(params.poses);
  if (!params.hypotheses.empty()) known.hypotheses.emplace(params.hypotheses);
  std::optional<figures::FigureFolder> figures;
  if (!params.plot.empty()) figures.emplace(params.plot, common.Existing());
  colour::ColourModel model = colour::ReadColourModel(params.model);
  recordings::ForwardFrames frames(params.forward);
  settings.camera_ahead_of_axle_m = frames.AheadOfAxleM();
  std::optional<colour::ChannelGains> gains;
  if (params.white_balance) gains = MeasureWhiteBalance(params, known, settings.lines, model);
  const std::unique_ptr<colour::ColourQuery> compass =
      MakeQuery(params, std::move(model), frames.Camera(), settings);

  reports::CompassQueryResult result = AskFrames(frames, known, gains, params.update, *compass);
  if ((known.poses || known.hypotheses) && result.frames > 0 &&
      result.unused.without_pose == result.frames) {
    recordings::RefuseRecording(
        frames, result.unused, params.poses.empty() ? params.hypotheses : params.poses);
  }
  if (result.headings.empty()) recordings::RefuseRecording(frames, result.unused, {});
  result.errors = ErrorsAgainst(truth, params, result);
  Store(params, common, result, *compass, summary);
  recordings::ReportFrames(frames, result.unused);
  if (figures) Draw(*figures, result, summary);
  result.seconds = terminal::SecondsSince(start);
  reports::Summarize(result, summary);
  if (!common.quiet) reports::PrintReport(result, summary);
}

void AddCompassOptions(CLI::App& cli, QueryOptions& params) {
  const std::string group = "Compass";
  cli.add_option("--poses",
                 params.poses,
                 "Poses of the robot, if known: position, pitch and roll; yaw is not used")
      ->type_name("T.tum")
      ->group("Input");
  cli.add_option("--hypotheses",
                 params.hypotheses,
                 "Places where the robot may be, of 'localize --hypotheses'; for times without a "
                 "pose")
      ->type_name("P.csv")
      ->group("Input");
  recordings::AddLineOptions(cli, params.lines, group);
  cli.add_option("--method",
                 params.method,
                 "bayes: a Bayes filter over yaw and place; victoria-2013: the query of the paper "
                 "[that of the model]")
      ->type_name("METHOD")
      ->check(CLI::IsMember({"bayes", kPrinted}))
      ->group(group);
  cli.add_option("--previous",
                 params.previous,
                 "victoria-2013: the previous heading in the query: turned by the measured turn, "
                 "held, or none (each frame by itself) [turned]")
      ->type_name("HOW")
      ->check(CLI::IsMember({"turned", "held", "none"}))
      ->group(group);
  cli.add_flag("--no-parallax",
               params.no_parallax,
               "bayes: the surroundings are taken to be infinitely far away")
      ->group(group);
  cli.add_flag(
         "--white-balance",
         params.white_balance,
         "The model was learned by another camera: match the mean colour of the recording, which "
         "is read twice")
      ->group(group);
  cli.add_flag("--update",
               params.update,
               "Update the model during the run, at the positions of --poses and its own headings")
      ->group(group);
}

}  // namespace

Command AddCompassQueryCommand(CLI::App& compass) {
  Command command = MakeCommand(
      compass,
      "query",
      "Finds the heading of a robot with a model of the surrounding colours.",
      "ceilmap compass query lab.colours --rig rig.yaml --forward again.mp4 --stamps again.csv -o "
      "heading.csv\n"
      "  ceilmap compass query lab.colours --rig rig.yaml --forward again.mp4 --truth truth.tum "
      "--plot figures -o heading.csv\n"
      "A SOURCE is a video file, a folder or printf pattern of images, a bag of ROS, /dev/videoN, "
      "or "
      "a URL.");
  auto params = std::make_shared<QueryOptions>();
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
  add("--save", params->save, "The model after --update", "MODEL2");
  add("--truth", params->truth, "True poses: errors, also as columns of H.csv", "T.tum");
  add("--plot", params->plot, "Folder for a figure with its gnuplot script and data", "DIR");
  params->settings.AddTo(cli);
  command.run = [params, &cli](const CommonOptions& common, terminal::Summary& summary) {
    RunQuery(*params, cli, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
