// A second robot in simulated worlds, rendered on the fly:
//   ceilmap_localize_bench consistency [-o DIR]          covariance against the truth, 10 worlds
//   ceilmap_localize_bench global SCENE.yaml [-o DIR]    switched on at 100 random places
//   ceilmap_localize_bench jumps SCENE.yaml [-o DIR]     carried away 20 times
//   ceilmap_localize_bench periodic SCENE.yaml [-o DIR]  a ceiling that repeats itself, with marks
//   ceilmap_localize_bench jumps-wheels|periodic-wheels SCENE.yaml [-o DIR]  with wheels
//   ceilmap_localize_bench changed SCENE.yaml [-o DIR]   a fifth of the ceiling is another one
//   ceilmap_localize_bench cameras SCENE.yaml [-o DIR]   cameras of all kinds
//   ceilmap_localize_bench speed [-o DIR]                tracking against plain registration
// DIR (default: the current folder) takes the maps; one that is there already is used again, so
// remove it when the mapping has changed. Exits with 1 when a bound is broken.

#include <fmt/format.h>

#include <opencv2/core.hpp>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/tilt.hpp"
#include "tests/bench/following.hpp"
#include "tests/bench/median.hpp"
#include "tests/bench/visit.hpp"
#include "tests/bench/world_run.hpp"
#include "tests/support/command_line.hpp"

namespace fs = std::filesystem;

namespace ceilmap::bench {
namespace {

bool RunGlobal(const simulator::Scene& scene, const fs::path& folder) {
  const World world(scene, folder / "world.gpkg");
  Visitor visitor(AnotherRobot(scene), world);
  constexpr int kPlaces = 100;
  constexpr int kFramesEach = 8;
  Places places(scene, 1);
  int right = 0;
  int wrong = 0;
  std::vector<double> search_ms;
  std::vector<double> frames_needed;
  for (int i = 0; i < kPlaces; ++i) {
    visitor.SwitchOn();
    const auto drive = places.NextDrive(kFramesEach);
    int frames = 0;
    bool found = false;
    for (const simulator::Frame& frame : drive) {
      const Visit visit = visitor.Locate(frame);
      ++frames;
      if (i > 0) search_ms.push_back(visit.milliseconds);  // the first one waits for the index
      if (!visit.location.Placed()) continue;
      found = true;
      (visit.Right() ? right : wrong) += 1;
      frames_needed.push_back(frames);
      if (!visit.Right()) fmt::print("place {}: off by {:.3f} m\n", i, visit.error_m);
      break;
    }
    if (!found) {
      const Pose2 at = FromSpace(drive.front().T_map_base).pose;
      fmt::print("place {}: {:.1f} {:.1f} not found\n", i, at.x, at.y);
    }
  }
  fmt::print(
      "right {} of {}, wrong {}; frames needed {:.0f} (median); a frame of searching {:.0f} ms "
      "(median), {:.0f} ms (largest)\n",
      right,
      kPlaces,
      wrong,
      Median(frames_needed),
      Median(search_ms),
      *std::max_element(search_ms.begin(), search_ms.end()));
  return right >= 95 && wrong == 0 && Median(search_ms) <= 150;
}

bool RunJumps(const simulator::Scene& scene, const fs::path& folder, bool has_wheels) {
  const World world(scene, folder / "world.gpkg");
  Visitor visitor(AnotherRobot(scene), world, has_wheels);
  constexpr int kJumps = 20;
  constexpr int kFramesEach = 25;
  Places places(scene, 2);
  int recovered = 0;
  int wrong = 0;
  double most = 0;
  double largest_error = 0;
  for (int jump = 0; jump <= kJumps; ++jump) {  // the first one switches the robot on
    int frames = 0;
    bool found = false;
    visitor.Carry();
    for (const simulator::Frame& frame : places.NextDrive(kFramesEach)) {
      const Visit visit = visitor.Locate(frame);
      frames += found ? 0 : 1;
      if (!visit.location.Placed()) continue;
      if (!visit.Right()) {
        ++wrong;
        fmt::print("jump {}: off by {:.3f} m\n", jump, visit.error_m);
      } else {
        found = true;
        largest_error = std::max(largest_error, visit.error_m);
      }
    }
    if (jump == 0) continue;
    if (found && frames <= 10) ++recovered;
    if (found) most = std::max(most, static_cast<double>(frames));
    if (!found) fmt::print("jump {}: not found again\n", jump);
  }
  fmt::print(
      "jumps {}, recovered within 10 frames {}, at the most after {:.0f} frames; wrong poses {}; "
      "largest error {:.1f} mm\n",
      kJumps,
      recovered,
      most,
      wrong,
      1e3 * largest_error);
  return recovered == kJumps && wrong == 0;
}

/// Tells when a robot under identical tiles sees anything that differs from place to place: its
/// image is not that of the same ceiling without marks.
class MarkWatch {
 public:
  explicit MarkWatch(const simulator::Renderer& marked)
      : marked_(marked), plain_(WithoutMarks(marked.GetScene())) {}

  [[nodiscard]] bool SeesAny(const simulator::Frame& frame) const {
    constexpr int kMinDifference = 8;  // grey levels
    constexpr int kMinPixels = 20;
    cv::Mat difference;
    cv::absdiff(marked_.Render(frame), plain_.Render(frame), difference);
    return cv::countNonZero(difference > kMinDifference) >= kMinPixels;
  }

 private:
  static simulator::Scene WithoutMarks(simulator::Scene scene) {
    scene.ceiling.marks = 0;
    return scene;
  }

  const simulator::Renderer& marked_;
  simulator::Renderer plain_;
};

bool RunPeriodic(const simulator::Scene& scene, const fs::path& folder, bool has_wheels) {
  const World world(scene, folder / "world.gpkg");
  Visitor visitor(AnotherRobot(scene), world, has_wheels);
  constexpr int kPlaces = 20;
  constexpr int kEnough = 20;  // placed frames: it stays right
  int accepted = 0;
  int wrong = 0;
  int found = 0;
  double travel_m = 0;
  double blind_m = 0;
  const MarkWatch watch(visitor.GetRenderer());
  std::vector<double> search_ms;
  for (int i = 0; i < kPlaces; ++i) {
    visitor.SwitchOn();
    simulator::Scene drive = visitor.GetRenderer().GetScene();
    drive.seed += static_cast<std::uint64_t>(i);  // another path each time
    drive.path.kind = simulator::PathKind::kRandomWalk;
    drive.path.length_m = 60;
    drive.path.max_frames = 400;
    int placed = 0;
    double distance_m = 0;
    std::optional<double> mark_m;  // travel until a mark is in view
    const std::vector<simulator::Frame> frames = simulator::MakePath(drive);
    for (std::size_t k = 0; k < frames.size() && placed < kEnough; ++k) {
      const Visit visit = visitor.Locate(frames[k]);
      if (placed == 0 && k > 0) {
        search_ms.push_back(visit.milliseconds);
        distance_m +=
            (frames[k].T_map_base.translation() - frames[k - 1].T_map_base.translation()).norm();
      }
      if (placed == 0 && !mark_m && watch.SeesAny(frames[k])) mark_m = distance_m;
      if (!visit.location.Placed()) continue;
      ++accepted;
      ++placed;
      if (!visit.Right()) {
        ++wrong;
        fmt::print("place {}: accepted with an error of {:.3f} m\n", i, visit.error_m);
      }
    }
    found += placed > 0 ? 1 : 0;
    if (placed > 0) travel_m += distance_m;
    if (placed > 0) blind_m += mark_m.value_or(distance_m);
    fmt::print("place {:2}: {}, {}\n",
               i,
               mark_m ? fmt::format("first mark after {:.1f} m", *mark_m) : "no mark",
               placed > 0 ? fmt::format("accepted after {:.1f} m", distance_m)
                          : fmt::format("not accepted within {:.1f} m", distance_m));
    std::fflush(stdout);
  }
  fmt::print(
      "places {}, found {} after {:.1f} m (mean), first mark after {:.1f} m; a frame until then "
      "{:.0f} ms (median); frames "
      "accepted {}, wrong {}\n",
      kPlaces,
      found,
      found > 0 ? travel_m / found : 0,
      found > 0 ? blind_m / found : 0,
      Median(search_ms),
      accepted,
      wrong);
  return wrong == 0 && 2 * found > kPlaces;
}

bool Run(const std::vector<std::string>& arguments) {
  const char* const usage =
      "ceilmap_localize_bench consistency|speed [-o DIR], or "
      "global|jumps|jumps-wheels|periodic|periodic-wheels|changed|cameras SCENE.yaml [-o DIR]";
  const auto needs_scene = [](const std::string& mode) {
    return mode != "consistency" && mode != "speed";
  };
  const auto [mode, scene_file, folder] = support::ParseCommandLine(arguments, needs_scene, usage);
  fs::create_directories(folder);
  if (mode == "consistency") return RunConsistency(folder);
  if (mode == "speed") return RunSpeed(folder);
  const simulator::Scene scene = simulator::ReadScene(scene_file);
  if (mode == "global") return RunGlobal(scene, folder);
  if (mode == "jumps") return RunJumps(scene, folder, false);
  if (mode == "jumps-wheels") return RunJumps(scene, folder, true);
  if (mode == "changed") return RunChanged(scene, folder);
  if (mode == "cameras") return RunCameras(scene, folder);
  if (mode == "periodic") return RunPeriodic(scene, folder, false);
  if (mode == "periodic-wheels") return RunPeriodic(scene, folder, true);
  throw InputError(usage);
}

}  // namespace
}  // namespace ceilmap::bench

int main(int argc, char** argv) {
  return ceilmap::support::RunBenchmark("ceilmap_localize_bench", argc, argv, ceilmap::bench::Run);
}
