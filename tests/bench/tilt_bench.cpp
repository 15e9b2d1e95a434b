// Debris in simulated worlds, rendered on the fly:
//   ceilmap_tilt_bench map SCENE.yaml [-o DIR]    the map made over debris against the one made on
//   a
//                                                 level floor
//   ceilmap_tilt_bench speed SCENE.yaml [-o DIR]  what measuring tilt costs, against registration
//   ceilmap_tilt_bench trust SCENE.yaml [-o DIR]  covariances of tilts compared with the truth, by
//                                                 size of the images
// The scene needs the group `debris`, and `forward` for what the forward camera adds. DIR (default:
// the current folder) takes the maps. Exits with 1 when a bound is broken.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "app/evaluation/trajectory_errors.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/tilt.hpp"
#include "compensation/tilt_estimator.hpp"
#include "mapping/registration/registrar.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/renderer.hpp"
#include "tests/bench/consistency.hpp"
#include "tests/bench/world_run.hpp"
#include "tests/support/command_line.hpp"

namespace ceilmap::bench {
namespace {

using compensation::TiltMethod;

constexpr double kMaxMapDifference_m = 0.004;
constexpr double kMaxCost = 4;  // registrations a pair of frames

struct Variant {
  const char* name;
  std::optional<TiltMethod> method;
  bool level = false;  // without debris
};

/// Where frames are on the map, by the best planar motion to the truth: what is left is the map's
/// own bending, and each frame's error on it.
std::map<std::int64_t, Eigen::Vector2d> Errors(const WorldRun& run) {
  Eigen::Vector2d mean_truth = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_seen = Eigen::Vector2d::Zero();
  const std::vector<graph::FramePose>& frames = run.graph.trajectory;
  const auto truth = [&run](const graph::FramePose& frame) -> Eigen::Vector2d {
    return run.truth[static_cast<std::size_t>(frame.frame_index)].position.head<2>();
  };
  for (const graph::FramePose& frame : frames) {
    mean_truth += truth(frame) / static_cast<double>(frames.size());
    mean_seen += frame.T_map_base.Translation() / static_cast<double>(frames.size());
  }
  double cross = 0;
  double dot = 0;
  for (const graph::FramePose& frame : frames) {
    const Eigen::Vector2d a = frame.T_map_base.Translation() - mean_seen;
    const Eigen::Vector2d b = truth(frame) - mean_truth;
    cross += a.x() * b.y() - a.y() * b.x();
    dot += a.dot(b);
  }
  const Eigen::Matrix2d turn = Pose2{0, 0, std::atan2(cross, dot)}.Rotation();
  std::map<std::int64_t, Eigen::Vector2d> errors;
  for (const graph::FramePose& frame : frames) {
    errors[frame.frame_index] =
        turn * (frame.T_map_base.Translation() - mean_seen) + mean_truth - truth(frame);
  }
  return errors;
}

struct Difference {
  double rmse_m = 0;
  double largest_m = 0;
  int count = 0;
};

/// Of the same frames in two runs; of keyframes alone, which are what the map is made of.
Difference Compare(const WorldRun& run, const WorldRun& level, bool keyframes_only) {
  const auto errors = Errors(run);
  const auto level_errors = Errors(level);
  std::vector<std::int64_t> indices;
  if (keyframes_only) {
    for (const graph::Keyframe& keyframe : run.graph.keyframes) {
      indices.push_back(keyframe.pose.frame_index);
    }
  } else {
    for (const auto& [index, error] : errors) indices.push_back(index);
  }
  Difference difference;
  double squares = 0;
  for (const std::int64_t index : indices) {
    if (!errors.contains(index) || !level_errors.contains(index)) continue;
    const double off = (errors.at(index) - level_errors.at(index)).norm();
    squares += off * off;
    difference.largest_m = std::max(difference.largest_m, off);
    ++difference.count;
  }
  difference.rmse_m = std::sqrt(squares / std::max(difference.count, 1));
  return difference;
}

bool CompareMaps(const support::CommandLine& line) {
  const simulator::Scene scene = simulator::ReadScene(line.scene);
  simulator::Scene level_scene = scene;
  level_scene.debris = {};
  std::vector<Variant> variants{{"level floor", std::nullopt, true},
                                {"level, ceiling", TiltMethod::kCeiling, true},
                                {"debris, none", std::nullopt},
                                {"debris, ceiling", TiltMethod::kCeiling}};
  if (scene.forward) {
    variants.push_back({"debris, matsumoto", TiltMethod::kMatsumoto});
    variants.push_back({"debris, forward", TiltMethod::kForward});
    variants.push_back({"debris, fused", TiltMethod::kFused});
  }
  fmt::print("{:18} {:>6} {:>6} {:>22} {:>22}\n",
             "",
             "frames",
             "keyfr.",
             "map mm RMSE / largest",
             "frames mm RMSE / largest");
  std::optional<WorldRun> level;
  bool good = true;
  for (const Variant& variant : variants) {
    WorldRun run = RunWorld(
        variant.level ? level_scene : scene, line.folder / "tilt.gpkg", {.tilt = variant.method});
    if (!level) level = run;
    const Difference map = Compare(run, *level, true);
    const Difference frames = Compare(run, *level, false);
    fmt::print("{:18} {:6} {:6} {:13.2f} / {:6.2f} {:13.2f} / {:6.2f}\n",
               variant.name,
               run.report.tracked,
               run.graph.keyframes.size(),
               1e3 * map.rmse_m,
               1e3 * map.largest_m,
               1e3 * frames.rmse_m,
               1e3 * frames.largest_m);
    // The published method has no bound: it is the baseline.
    if (variant.method == TiltMethod::kMatsumoto) continue;
    const bool bound = variant.method && *variant.method != TiltMethod::kForward;
    if (bound && map.rmse_m > kMaxMapDifference_m) good = false;
    if (run.report.lost > 0 && variant.method) good = false;
  }
  return good;
}

double Milliseconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - start;
  return spent.count();
}

/// One thread's time: the two cameras are measured one after the other.
bool MeasureSpeed(const support::CommandLine& line) {
  const simulator::Scene scene = simulator::ReadScene(line.scene);
  const simulator::Renderer renderer(scene);
  std::vector<simulator::Frame> frames = simulator::MakePath(scene);
  constexpr std::size_t kMax = 80;
  frames.resize(std::min(frames.size(), kMax));
  std::vector<compensation::TiltFrame> inputs;
  for (const simulator::Frame& frame : frames) {
    const cv::Mat forward = scene.forward ? renderer.RenderForward(frame) : cv::Mat();
    inputs.push_back({renderer.Render(frame), forward, frame.stamp_s});
  }
  registration::Registrar registrar(inputs.front().up.size());
  registration::FrameSpectrum before = registrar.Analyze(inputs.front().up);
  const double registering = Milliseconds([&] {
    for (const compensation::TiltFrame& input : inputs) {
      registration::FrameSpectrum now = registrar.Analyze(input.up);
      (void)registrar.Register(before, now);
      before = now;
    }
  });
  compensation::TiltEstimator estimator(renderer.GetRig());
  for (const compensation::TiltFrame& input : inputs) (void)estimator.Estimate(input);
  const auto count = static_cast<double>(inputs.size());
  const compensation::TiltReport& report = estimator.Report();
  const double ratio = (report.ceiling_ms + report.forward_ms) / registering;
  fmt::print(
      "registering a frame with the one before {:.2f} ms; tilt by the ceiling {:.2f} ms, by the "
      "forward camera {:.2f} ms: {:.2f} registrations\n",
      registering / count,
      report.ceiling_ms / count,
      report.forward_ms / count,
      ratio);
  return ratio <= kMaxCost;
}

/// Tilts of a drive against the truth.
struct TiltTrust {
  Consistency ceiling;  ///< as the ceiling showed them
  Consistency tilt;     ///< as the robot is told, where they have a covariance
  int invented = 0;     ///< level frames with a tilt of more than kInventedRad
  int frames = 0;
};

TiltTrust DriveTilted(const simulator::Scene& scene) {
  constexpr double kLevelRad = 1e-4;
  constexpr double kInventedRad = 3.5e-3;  // 0.2 degrees
  const simulator::Renderer renderer(scene);
  compensation::TiltEstimatorParams params;
  params.method = TiltMethod::kCeiling;
  compensation::TiltEstimator estimator(renderer.GetRig(), params);
  TiltTrust trust;
  for (const simulator::Frame& frame : simulator::MakePath(scene)) {
    const compensation::TiltEstimate estimate =
        estimator.Estimate({renderer.Render(frame), {}, frame.stamp_s});
    const Tilt truth = FromSpace(frame.T_map_base).tilt;
    const Eigen::Vector2d true_angles(truth.pitch_rad, truth.roll_rad);
    const Eigen::Vector2d told(estimate.tilt.pitch_rad, estimate.tilt.roll_rad);
    ++trust.frames;
    trust.invented += true_angles.norm() < kLevelRad && told.norm() > kInventedRad ? 1 : 0;
    if (!estimate.by_ceiling) continue;
    const Eigen::Vector2d error = estimate.by_ceiling->angles - true_angles;
    Consistency one = ConsistencyOf(error, estimate.by_ceiling->covariance, {});
    one.error2 = error.squaredNorm() * kDegPerRad * kDegPerRad;
    trust.ceiling.Add(one);
    if (estimate.tilt.covariance.isZero()) continue;
    trust.tilt.Add(ConsistencyOf(told - true_angles, estimate.tilt.covariance, {}));
  }
  return trust;
}

bool CheckTrust(const support::CommandLine& line) {
  constexpr double kMaxNees = 2;
  fmt::print("{:10} {:>6} {:>8} {:>8} {:>8} {:>10} {:>8} {:>8} {:>8}\n",
             "images",
             "frames",
             "measured",
             "NEES/2",
             "in 95%",
             "RMSE deg",
             "told",
             "NEES/2",
             "invented");
  bool good = true;
  for (const int part : {1, 2, 4}) {
    simulator::Scene scene = simulator::ReadScene(line.scene);
    scene.camera.width_px /= part;
    scene.camera.height_px /= part;
    scene.camera.focal_px /= part;
    const TiltTrust trust = DriveTilted(scene);
    const Consistency& ceiling = trust.ceiling;
    fmt::print("{:10} {:6} {:8} {:8.2f} {:8.3f} {:10.4f} {:8} {:8.2f} {:8}\n",
               fmt::format("{}x{}", scene.camera.width_px, scene.camera.height_px),
               trust.frames,
               ceiling.found,
               ceiling.Nees(),
               ceiling.Share(),
               std::sqrt(ceiling.error2 / std::max(1, ceiling.found)),
               trust.tilt.found,
               trust.tilt.Nees(),
               trust.invented);
    good = good && ceiling.Nees() < kMaxNees;
  }
  return good;
}

bool Run(const std::vector<std::string>& arguments) {
  constexpr const char* kUsage = "map|speed|trust SCENE.yaml [-o DIR]";
  const support::CommandLine line = support::ParseCommandLine(
      arguments, [](const std::string&) { return true; }, kUsage);
  if (line.mode == "map") return CompareMaps(line);
  if (line.mode == "speed") return MeasureSpeed(line);
  if (line.mode == "trust") return CheckTrust(line);
  throw InputError(fmt::format("usage: {}", kUsage));
}

}  // namespace
}  // namespace ceilmap::bench

int main(int argc, char** argv) {
  return ceilmap::support::RunBenchmark("ceilmap_tilt_bench", argc, argv, ceilmap::bench::Run);
}
