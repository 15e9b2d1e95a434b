// Large and hard simulated worlds, rendered on the fly and mapped:
//   ceilmap_world_bench accuracy SCENE.yaml [-o DIR]  accuracy against the truth
//   ceilmap_world_bench growth SCENE.yaml [-o DIR]    time and memory, with a plot
//   ceilmap_world_bench periodic SCENE.yaml [-o DIR]  20 seeds of a ceiling that repeats itself
//   ceilmap_world_bench heading SCENE.yaml [-o DIR]   without and with the camera under the mirror
// DIR (default: the current folder) takes the map, curve.csv, curve.svg, truth.tum, map.tum. Exits
// with 1 when a bound is broken.

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "app/evaluation/trajectory_errors.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"
#include "tests/bench/world_run.hpp"
#include "tests/support/command_line.hpp"

namespace fs = std::filesystem;

namespace ceilmap::bench {
namespace {

constexpr double kMaxRmse_m = 0.01;
constexpr double kMaxResidentMb = 1500;
constexpr double kMaxGrowth = 1.3;
constexpr double kFalseClosure_m = 0.1;
constexpr int kSeeds = 20;
constexpr double kMaxPeriodicError_m = 0.1;  // a sixth of a tile

void ShowProgress(std::int64_t done, std::int64_t total) {
  if (done % 500 == 0 || done == total) fmt::print(stderr, "\r{}/{} frames ", done, total);
  if (done == total) fmt::print(stderr, "\n");
}

int FalseClosures(const WorldRun& run) {
  return static_cast<int>(
      std::count_if(run.closures.begin(), run.closures.end(), [](const ClosureCheck& closure) {
        return closure.error_m > kFalseClosure_m;
      }));
}

int Spots(const WorldRun& run, graph::WeakSpot::Kind kind) {
  const auto& spots = run.graph.weak_spots;
  return static_cast<int>(
      std::count_if(spots.begin(), spots.end(), [kind](const graph::WeakSpot& spot) {
        return spot.kind == kind;
      }));
}

void WriteTum(const fs::path& file, const std::vector<StampedPose>& poses) {
  std::ofstream(file) << files::FormatTum(poses);
}

/// @return whether the position is as exact as asked.
bool ReportAccuracy(const WorldRun& run) {
  const auto errors = evaluation::EvaluateTrajectory(run.truth, run.estimate);
  const mapping::MapperReport& report = run.report;
  const graph::LoopCounts& loops = report.quality.loops;
  fmt::print("frames        {} ({} tracked, {} lost, {} ambiguous, {} unconnected), {} keyframes\n",
             report.frames,
             report.tracked,
             report.lost,
             report.ambiguous,
             report.unconnected,
             report.keyframes);
  fmt::print(
      "loops         {} accepted of {} compared: {} no match, {} ambiguous, {} off, {} "
      "unconfirmed; {} outliers\n",
      loops.accepted,
      loops.compared,
      loops.no_match,
      loops.ambiguous,
      loops.off_prediction,
      loops.unconfirmed,
      loops.outliers);
  fmt::print("false         {} of {} closures in the map are off by more than {} m\n",
             FalseClosures(run),
             run.closures.size(),
             kFalseClosure_m);
  fmt::print("quality       chi2/dof {:.2f}, odometry {:.2f} mm, loops {:.2f} mm RMS\n",
             report.quality.chi2_per_dof,
             1e3 * report.quality.odometry_rms,
             1e3 * report.quality.loop_rms);
  fmt::print(
      "time          {:.1f} s, {:.2f} ms a frame; loops {:.2f} ms a keyframe, optimize {:.1f} s, "
      "mosaic {:.1f} s\n",
      run.seconds,
      1e3 * run.seconds / static_cast<double>(report.frames),
      report.loop_ms / static_cast<double>(report.keyframes),
      report.optimize_ms / 1e3,
      report.mosaic_ms / 1e3);
  fmt::print("file          {:.0f} MB, mosaic {} x {} px\n",
             run.file_mb,
             report.grid.width_px,
             report.grid.height_px);
  if (!errors) {
    fmt::print("accuracy      no pose matches the truth\n");
    return false;
  }
  fmt::print(
      "accuracy      path {:.0f} m, coverage {:.4f}, position RMSE {:.2f} mm, max {:.2f} mm, "
      "yaw RMSE {:.4f} deg\n",
      errors->path_m,
      errors->Coverage(),
      1e3 * errors->position_m.rmse,
      1e3 * errors->position_m.max,
      errors->yaw_deg.rmse);
  return errors->position_m.rmse <= kMaxRmse_m;
}

/// The curve as text, and as curve.svg beside curve.csv.
void Plot(const fs::path& folder) {
  const std::string common = fmt::format(
      "set datafile separator ','; set key top left; set xlabel 'frames'; set yrange [0:*]; "
      "csv = '{}'; ",
      (folder / "curve.csv").string());
  const auto curves = [](const char* title, const char* columns) {
    return fmt::format("set title '{}'; plot {}; ", title, columns);
  };
  const std::string time = curves("time per frame, ms",
                                  "csv using 1:4 skip 1 with linespoints title 'all threads', csv "
                                  "using 1:3 skip 1 with linespoints title 'wall'");
  const std::string memory =
      curves("resident memory, MB", "csv using 1:5 skip 1 with linespoints notitle");
  std::FILE* gnuplot = ::popen("gnuplot 2>&1", "w");
  if (gnuplot == nullptr) return;
  fmt::print(gnuplot, "{}set terminal dumb 100 22; {}{}\n", common, time, memory);
  fmt::print(gnuplot,
             "set terminal svg size 900,700; set output '{}'; set multiplot layout 2,1; {}{}\n",
             (folder / "curve.svg").string(),
             time,
             memory);
  if (::pclose(gnuplot) != 0) fmt::print("no plot: it needs gnuplot\n");
}

/// Means over the first and the last fifth.
struct Ends {
  double first = 0;
  double last = 0;
};
Ends EndsOf(const std::vector<CostSample>& curve, double CostSample::*value) {
  const std::size_t part = std::max<std::size_t>(1, curve.size() / 5);
  Ends ends;
  for (std::size_t i = 0; i < part; ++i) {
    ends.first += curve[i].*value / static_cast<double>(part);
    ends.last += curve[curve.size() - 1 - i].*value / static_cast<double>(part);
  }
  return ends;
}

bool ReportGrowth(const WorldRun& run, const fs::path& folder) {
  std::ofstream csv(folder / "curve.csv");
  csv << "frame,map_m2,wall_ms,cpu_ms,resident_mb\n";
  for (const CostSample& sample : run.curve) {
    csv << fmt::format("{},{:.0f},{:.3f},{:.3f},{:.1f}\n",
                       sample.frame,
                       sample.map_m2,
                       sample.wall_ms,
                       sample.cpu_ms,
                       sample.resident_mb);
  }
  csv.close();
  std::fflush(stdout);
  Plot(folder);
  const Ends wall = EndsOf(run.curve, &CostSample::wall_ms);
  const Ends cpu = EndsOf(run.curve, &CostSample::cpu_ms);
  const double growth = std::max(wall.last / wall.first, cpu.last / cpu.first);
  fmt::print(
      "time growth   wall {:.2f} -> {:.2f} ms ({:.2f}), all threads {:.2f} -> {:.2f} ms "
      "({:.2f}); at most {}\n",
      wall.first,
      wall.last,
      wall.last / wall.first,
      cpu.first,
      cpu.last,
      cpu.last / cpu.first,
      kMaxGrowth);
  fmt::print(
      "memory        {:.0f} MB at the most, simulator included; at most {:.0f}; {:.0f} m2 "
      "mapped\n",
      run.peak_mb,
      kMaxResidentMb,
      run.curve.back().map_m2);
  return growth <= kMaxGrowth && run.peak_mb <= kMaxResidentMb;
}

bool RunOne(const simulator::Scene& scene, const fs::path& folder, bool growth) {
  const WorldRun run =
      RunWorld(scene, folder / "world.gpkg", {.samples = 50, .progress = ShowProgress});
  WriteTum(folder / "truth.tum", run.truth);
  WriteTum(folder / "map.tum", run.estimate);
  const bool exact = ReportAccuracy(run);
  return growth ? ReportGrowth(run, folder) : exact && FalseClosures(run) == 0;
}

bool RunSeeds(simulator::Scene scene, const fs::path& folder) {
  int total = 0;
  bool reported = true;
  fmt::print(
      "seed  frames  closures  false  largest off  ambiguous  weak spots: ambiguous lost  "
      "position RMSE\n");
  for (int seed = 1; seed <= kSeeds; ++seed) {
    scene.seed = static_cast<std::uint64_t>(seed);
    const WorldRun run = RunWorld(scene, folder / "world.gpkg");
    const auto errors = evaluation::EvaluateTrajectory(run.truth, run.estimate);
    double largest = 0;
    for (const ClosureCheck& closure : run.closures) largest = std::max(largest, closure.error_m);
    const int ambiguous = Spots(run, graph::WeakSpot::Kind::kAmbiguous);
    fmt::print("{:4}  {:6}  {:8}  {:5}  {:8.1f} mm  {:9}  {:21} {:4}  {:10.1f} mm\n",
               seed,
               run.report.frames,
               run.closures.size(),
               FalseClosures(run),
               1e3 * largest,
               run.report.quality.loops.ambiguous,
               ambiguous,
               Spots(run, graph::WeakSpot::Kind::kLost),
               errors ? 1e3 * errors->position_m.rmse : -1.0);
    std::fflush(stdout);
    total += FalseClosures(run);
    reported = reported && ambiguous > 0;
  }
  fmt::print("false loop closures in {} seeds: {}; every map reports where it is ambiguous: {}\n",
             kSeeds,
             total,
             reported ? "yes" : "no");
  return total == 0 && reported;
}

/// The largest error of yaws that count from their first one, degrees. @return -1 without any.
double LargestTurnError(const std::vector<StampedPose>& truth,
                        const std::vector<StampedPose>& yaws) {
  double largest = -1;
  double first = 0;
  std::size_t next = 0;
  for (const StampedPose& pose : truth) {
    if (next == yaws.size()) break;
    if (yaws[next].stamp_s != pose.stamp_s) continue;
    const double off = YawOf(yaws[next]) - YawOf(pose);
    if (next++ == 0) first = off;
    largest = std::max(largest, kDegPerRad * std::abs(WrapAngle(off - first)));
  }
  return largest;
}

// A compass cannot give the position in the dark, but it must give the yaw.
constexpr double kTurned_deg = 10;

const char* Verdict(bool whole, double turn_error_deg) {
  if (whole) return "success";
  return turn_error_deg < kTurned_deg ? "undetermined: the yaw is right, the tile is ambiguous"
                                      : "failure: turned wrong, and a part is not in the map";
}

/// Does the map hold the drive, every frame of it in its place?
bool ReportHeading(const char* name, const WorldRun& run) {
  const auto errors = evaluation::EvaluateTrajectory(run.truth, run.estimate);
  const double coverage = errors ? errors->Coverage() : 0;
  const double largest = errors ? errors->position_m.max : -1;
  const bool whole = coverage > 0.98 && largest < kMaxPeriodicError_m;
  fmt::print("{:12} {:6} {:7} {:9} {:4} {:11}  {:8.3f} {:10.1f} {:9.2f} {:9.2f}  {}\n",
             name,
             run.report.frames,
             run.report.tracked,
             run.report.ambiguous,
             run.report.lost,
             run.report.unconnected,
             coverage,
             1e3 * largest,
             LargestTurnError(run.truth, run.live),
             LargestTurnError(run.truth, run.compass),
             Verdict(whole, LargestTurnError(run.truth, run.live)));
  std::fflush(stdout);
  return whole;
}

bool RunHeading(const simulator::Scene& scene, const fs::path& folder) {
  fmt::print(
      "             frames tracked ambiguous lost unconnected  coverage max off mm  odometry   "
      "compass\n");
  const bool without = ReportHeading("without", RunWorld(scene, folder / "world.gpkg"));
  const WorldRun run = RunWorld(scene, folder / "world-omni.gpkg", {.omni = true});
  const bool with = ReportHeading("with --omni", run);
  fmt::print("(odometry, compass: largest error of their yaw over all placed frames, deg)\n");
  return !without && (with || LargestTurnError(run.truth, run.live) < kTurned_deg);
}

bool Run(const std::vector<std::string>& arguments) {
  const auto [mode, scene_file, folder] = support::ParseCommandLine(
      arguments,
      [](const std::string&) { return true; },
      "ceilmap_world_bench accuracy|growth|periodic|heading SCENE.yaml [-o DIR]");
  const simulator::Scene scene = simulator::ReadScene(scene_file);
  fs::create_directories(folder);
  if (mode == "accuracy" || mode == "growth") return RunOne(scene, folder, mode == "growth");
  if (mode == "periodic") return RunSeeds(scene, folder);
  if (mode == "heading") return RunHeading(scene, folder);
  throw InputError(fmt::format("'{}': must be accuracy, growth, periodic or heading", mode));
}

}  // namespace
}  // namespace ceilmap::bench

int main(int argc, char** argv) {
  return ceilmap::support::RunBenchmark("ceilmap_world_bench", argc, argv, ceilmap::bench::Run);
}
