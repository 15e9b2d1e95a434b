#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "app/commands/compass_commands.hpp"
#include "app/commands/settings_options.hpp"
#include "app/files/arguments.hpp"
#include "app/files/output_files.hpp"
#include "app/recordings/compass_frames.hpp"
#include "app/reports/compass_report.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "localization/compass/colour/colour_compass.hpp"
#include "localization/compass/colour/colour_learner.hpp"
#include "localization/compass/colour/colour_model_file.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using std::chrono::steady_clock;

struct LearnCommandOptions {
  recordings::ForwardOptions forward;
  fs::path poses;
  fs::path hypotheses;
  std::string method = "victoria";
  std::string clustering = "auto";
  std::string grid;
  colour::LearnParams learn;
  fs::path output;
  SettingsOptions settings;

  // Checks everything that can be checked without the recording. @throws InputError
  void Resolve(const CLI::App& cli, files::Existing existing);

 private:
  void TakeSettings(const CLI::App& cli);
};

// A whole number of cells. A limit detects typing errors.
int CellCount(double number, const std::string& text) {
  constexpr double kMaxCells = 100;
  if (number >= 1 && number <= kMaxCells && number == std::floor(number)) {
    return static_cast<int>(number);
  }
  throw InputError(
      fmt::format("--grid {}: COLUMNS and ROWS must be whole numbers in 1..100", text));
}

colour::GridGeometry ParseGrid(const std::string& text) {
  const auto numbers = files::ParseSixNumbers(text);
  if (!numbers) {
    throw InputError(fmt::format(
        "--grid {}: must be MIN_X,MIN_Y,WIDTH,HEIGHT,COLUMNS,ROWS in metres and cells, e.g. "
        "-3,-2,6,4,5,3",
        text));
  }
  const auto& [min_x, min_y, width, height, columns, rows] = *numbers;
  if (!(width > 0) || !(height > 0)) {
    throw InputError(fmt::format("--grid {}: WIDTH and HEIGHT must be > 0", text));
  }
  return {min_x, min_y, width, height, CellCount(columns, text), CellCount(rows, text)};
}

// Values of the settings file, where no option gives another one.
void LearnCommandOptions::TakeSettings(const CLI::App& cli) {
  const colour::LearnParams file = settings.Read().colour_learn;
  const auto take = [&cli](const char* option, auto& value, const auto& in_file) {
    if (cli.count(option) == 0) value = in_file;
  };
  take("--method", learn.kind, file.kind);
  take("--clustering", learn.classes.clustering, file.classes.clustering);
  take("--classes", learn.classes.classes, file.classes.classes);
  take("--bins", learn.bins, file.bins);
  take("--fading", learn.fading_s, file.fading_s);
  colour::ScanLineParams lines = file.lines;
  recordings::TakeLineOptions(cli, learn.lines, lines);
  learn.lines = lines;
}

void LearnCommandOptions::Resolve(const CLI::App& cli, files::Existing existing) {
  for (const auto kind : {colour::ModelKind::kSturm, colour::ModelKind::kVictoria2013}) {
    if (method == colour::ToString(kind)) learn.kind = kind;
  }
  if (clustering == "mixture") learn.classes.clustering = colour::Clustering::kMixture;
  if (clustering == "kmeans") learn.classes.clustering = colour::Clustering::kMeans;
  TakeSettings(cli);
  if (!grid.empty()) {
    if (learn.kind == colour::ModelKind::kSturm) {
      throw InputError(
          "--grid: is an option of --method victoria; sturm has one place; leave "
          "it out");
    }
    learn.grid = ParseGrid(grid);
  }
  learn.Validate();
  forward.CheckResult(output);
  recordings::CheckNotRead(output, {poses, hypotheses});
  files::CheckOutputFiles({output}, existing);
}

// The robot may be at several places: that of the most weight is learned.
colour::LearnedPose LearnedFrom(const files::StampedHypotheses& hypotheses) {
  colour::LearnedPose learned;
  double most = 0;
  for (const WeightedPose& place : hypotheses.places) {
    learned.places.push_back({place.pose.Translation(), place.weight});
    if (place.weight <= most) continue;
    most = place.weight;
    learned.T_map_base = place.pose;
  }
  return learned;
}

colour::LearnedPose LearnedFrom(const StampedPose& pose) {
  colour::LearnedPose learned;
  learned.T_map_base = {pose.position.x(), pose.position.y(), YawOf(pose)};
  learned.tilt = recordings::TiltOf(pose);
  return learned;
}

// Reads a recording at known poses. `learn` takes a frame and its pose and returns whether it was
// used.
template <typename Learn>
reports::CompassLearnResult LearnFrames(recordings::ForwardFrames& frames,
                                        const fs::path& poses_file,
                                        const fs::path& hypotheses_file,
                                        const char* label,
                                        const Learn& learn) {
  const recordings::PosesByTime poses(poses_file);
  std::optional<recordings::HypothesesByTime> hypotheses;
  if (!hypotheses_file.empty()) hypotheses.emplace(hypotheses_file);
  reports::CompassLearnResult result;
  terminal::Progress progress(label, "frames", frames.Source().ExpectedFrames());
  while (frames.Read()) {
    progress.Update(frames.Count());
    const recordings::Frame& frame = frames.Current();
    const StampedPose* const pose = poses.Nearest(frame.stamp_s);
    const files::StampedHypotheses* const places =
        pose == nullptr && hypotheses ? hypotheses->Nearest(frame.stamp_s) : nullptr;
    if (pose == nullptr && places == nullptr) {
      ++result.unused.without_pose;
      terminal::Detail("frame {} at {:.6f} s: no pose", frame.index, frame.stamp_s);
      continue;
    }
    const auto start = steady_clock::now();
    const bool used = learn(frame, pose != nullptr ? LearnedFrom(*pose) : LearnedFrom(*places));
    result.learn_ms += terminal::MillisecondsSince(start);
    ++(used ? result.used : result.unused.below_horizon);
    terminal::Detail("frame {} at {:.6f} s: {}",
                     frame.index,
                     frame.stamp_s,
                     used ? "learned" : "skipped, too little above the horizon");
  }
  result.frames = frames.Count();
  if (result.used == 0) recordings::RefuseRecording(frames, result.unused, poses_file);
  result.reading = frames.Source().Report();
  return result;
}

// Stores the model and prints a report.
void Finish(const colour::ColourModel& model,
            const fs::path& output,
            const recordings::ForwardFrames& frames,
            const CommonOptions& common,
            steady_clock::time_point start,
            reports::CompassLearnResult& result,
            terminal::Summary& summary) {
  colour::WriteColourModel(model, output);
  summary.files.push_back(output);
  recordings::ReportFrames(frames, result.unused);
  result.seconds = terminal::SecondsSince(start);
  reports::Summarize(result, model, summary);
  if (!common.quiet) reports::PrintReport(result, model, summary);
}

void RunLearn(LearnCommandOptions params,
              const CLI::App& cli,
              const CommonOptions& common,
              terminal::Summary& summary) {
  const auto start = steady_clock::now();
  params.Resolve(cli, common.Existing());
  CommandSettings resolved;
  resolved.colour_learn = params.learn;
  summary.settings = SettingsJson(resolved, {"colour_learn"});
  recordings::ForwardFrames frames(params.forward);
  params.learn.camera_ahead_of_axle_m = frames.AheadOfAxleM();
  colour::ColourLearner learner(frames.Camera(), params.learn);
  reports::CompassLearnResult result =
      LearnFrames(frames,
                  params.poses,
                  params.hypotheses,
                  "learning",
                  [&learner](const recordings::Frame& frame, const colour::LearnedPose& pose) {
                    return learner.Add(frame.image, frame.stamp_s, pose);
                  });
  const auto finishing = steady_clock::now();
  colour::ColourModel model = learner.Finish();
  result.learn_ms += terminal::MillisecondsSince(finishing);
  model.provenance = common.command_line;
  Finish(model, params.output, frames, common, start, result, summary);
}

struct UpdateCommandOptions {
  fs::path model;
  recordings::ForwardOptions forward;
  fs::path poses;
  fs::path hypotheses;
  colour::ScanLineParams lines = {};
  fs::path output;  // empty: the input model itself
  SettingsOptions settings;
};

void RunUpdate(const UpdateCommandOptions& params,
               const CLI::App& cli,
               const CommonOptions& common,
               terminal::Summary& summary) {
  const auto start = steady_clock::now();
  const fs::path& output = params.output.empty() ? params.model : params.output;
  params.forward.CheckResult(output);
  recordings::CheckNotRead(output, {params.poses, params.hypotheses});
  files::CheckOutputFiles({output}, common.Existing(), params.model);
  CommandSettings resolved = params.settings.Read();
  colour::ColourCompassParams& settings = resolved.colour_compass;
  recordings::TakeLineOptions(cli, params.lines, settings.lines);
  settings.Validate();
  summary.settings = SettingsJson(resolved, {"colour_compass"});
  colour::ColourModel stored = colour::ReadColourModel(params.model);
  stored.provenance += (stored.provenance.empty() ? "" : "\n") + common.command_line;
  recordings::ForwardFrames frames(params.forward);
  settings.camera_ahead_of_axle_m = frames.AheadOfAxleM();
  colour::ColourCompass compass(std::move(stored), frames.Camera(), settings);
  reports::CompassLearnResult result =
      LearnFrames(frames,
                  params.poses,
                  params.hypotheses,
                  "updating",
                  [&compass](const recordings::Frame& frame, const colour::LearnedPose& pose) {
                    colour::ColourFrame seen;
                    seen.bgr = frame.image;
                    seen.stamp_s = frame.stamp_s;
                    seen.tilt = pose.tilt;
                    const colour::PlaceHypothesis place{pose.T_map_base.Translation()};
                    seen.places = {&place, 1};
                    if (!pose.places.empty()) seen.places = pose.places;
                    if (!compass.Next(seen)) return false;
                    compass.Learn(pose);
                    return true;
                  });
  Finish(compass.Model(), output, frames, common, start, result, summary);
}

void AddPoses(CLI::App& cli, fs::path& poses, fs::path& hypotheses) {
  cli.add_option(
         "--poses", poses, "Poses of the robot; the nearest within 50 ms of each frame is used")
      ->type_name("T.tum")
      ->group("Input")
      ->required();
  cli.add_option("--hypotheses",
                 hypotheses,
                 "Places where the robot may be, of 'localize --hypotheses'; for times without a "
                 "pose: the likeliest is learned, by its cell's share of them")
      ->type_name("P.csv")
      ->group("Input");
}

void AddModelOptions(CLI::App& cli, LearnCommandOptions& params) {
  const std::string group = "Model";
  constexpr int kMinBins = 36;
  constexpr int kMaxBins = 720;
  const auto add = [&](const char* name, auto& value, const char* text, const char* type) {
    return cli.add_option(name, value, text)->type_name(type)->group(group);
  };
  add("--method",
      params.method,
      "victoria: a grid of places; victoria-2013: the same with the storage of the paper; sturm: "
      "one "
      "cylinder",
      "METHOD")
      ->check(CLI::IsMember({"victoria", "victoria-2013", "sturm"}))
      ->capture_default_str();
  add("--classes", params.learn.classes.classes, "Number of colour classes", "K")
      ->check(CLI::Range(2, colour::kMaxClasses))
      ->capture_default_str();
  add("--clustering",
      params.clustering,
      "Clustering of the colours: kmeans, mixture, or auto: mixture for sturm, else kmeans",
      "HOW")
      ->check(CLI::IsMember({"auto", "kmeans", "mixture"}))
      ->capture_default_str();
  add("--bins", params.learn.bins, "Number of directions of each cell", "N")
      ->check(CLI::Range(kMinBins, kMaxBins))
      ->capture_default_str();
  add("--grid",
      params.grid,
      "Grid of cells in the frame of the poses [6 x 4 m around their centre, 5 x 3 cells]",
      "MIN_X,MIN_Y,WIDTH,HEIGHT,COLUMNS,ROWS");
  add("--fading", params.learn.fading_s, "Time constant of forgetting, seconds", "S")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  add("--depth", params.learn.depth_m, "Distance of the surroundings, metres [measured]", "M")
      ->check(CLI::PositiveNumber);
  add("--seed", params.learn.classes.seed, "Seed of the clustering", "N")->capture_default_str();
  recordings::AddLineOptions(cli, params.learn.lines, group);
}

}  // namespace

Command AddCompassLearnCommand(CLI::App& compass) {
  Command command = MakeCommand(
      compass,
      "learn",
      "Learns a model of the surrounding colours from a recording at known poses.",
      "ceilmap compass learn --rig rig.yaml --forward forward.mp4 --stamps frames.csv --poses "
      "truth.tum -o lab.colours");
  auto params = std::make_shared<LearnCommandOptions>();
  params->forward.AddTo(*command.cli, "Input");
  AddPoses(*command.cli, params->poses, params->hypotheses);
  AddModelOptions(*command.cli, *params);
  command.cli->add_option("-o,--output", params->output, "The model")
      ->required()
      ->type_name("MODEL")
      ->group("Results");
  params->settings.AddTo(*command.cli);
  command.run = [params, cli = command.cli](const CommonOptions& common,
                                            terminal::Summary& summary) {
    RunLearn(*params, *cli, common, summary);
  };
  return command;
}

Command AddCompassUpdateCommand(CLI::App& compass) {
  Command command = MakeCommand(
      compass,
      "update",
      "Updates a model from a recording at known poses.",
      "ceilmap compass update lab.colours --rig rig.yaml --forward later.mp4 --stamps later.csv "
      "--poses later.tum");
  auto params = std::make_shared<UpdateCommandOptions>();
  command.cli->add_option("model", params->model, "The model; it is replaced at the end")
      ->required()
      ->type_name("MODEL");
  params->forward.AddTo(*command.cli, "Input");
  AddPoses(*command.cli, params->poses, params->hypotheses);
  recordings::AddLineOptions(*command.cli, params->lines, "Input");
  command.cli->add_option("-o,--output", params->output, "Write to this file instead")
      ->type_name("MODEL")
      ->group("Results");
  params->settings.AddTo(*command.cli);
  command.run = [params, cli = command.cli](const CommonOptions& common,
                                            terminal::Summary& summary) {
    RunUpdate(*params, *cli, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
