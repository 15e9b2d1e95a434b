// A second robot in simulated worlds, rendered on the fly:
//   ceilmap_localize_bench consistency [-o DIR]          covariance against the truth, 10 worlds
//   ceilmap_localize_bench global SCENE.yaml [-o DIR]    switched on at 100 random places
//   ceilmap_localize_bench jumps SCENE.yaml [-o DIR]     carried away 20 times
//   ceilmap_localize_bench periodic SCENE.yaml [-o DIR]  a ceiling that repeats itself, with marks
//   ceilmap_localize_bench changed SCENE.yaml [-o DIR]   a fifth of the ceiling is another one
//   ceilmap_localize_bench cameras SCENE.yaml [-o DIR]   cameras of all kinds
//   ceilmap_localize_bench speed [-o DIR]                tracking against plain registration
// DIR (default: the current folder) takes the maps; one that is there already is used again, so
// remove it when the mapping has changed. Exits with 1 when a bound is broken.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "calib/error.hpp"
#include "mapping/registration/registrar.hpp"
#include "tests/bench/visit.hpp"
#include "tests/bench/world_run.hpp"

namespace fs = std::filesystem;

namespace ceilmap::bench {
namespace {

using localization::Location;
using mapping::TrackingStatus;

constexpr double kRight_m = 0.05;
constexpr double kRight_rad = 0.02;
constexpr double kPeriod_s = 0.1;

bool Right(const Visit& visit) {
  return visit.error_m < kRight_m && visit.error_rad < kRight_rad;
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void ShowProgress(std::int64_t done, std::int64_t total) {
  if (done % 200 == 0 || done == total) fmt::print(stderr, "\rmapping {}/{} ", done, total);
  if (done == total) fmt::print(stderr, "\n");
}

/// A world, its map and where that lies in the room.
struct World {
  World(const simulator::Scene& world, const fs::path& file) : scene(world) {
    if (!fs::exists(file)) RunWorld(scene, file, 1, ShowProgress);
    map = std::make_unique<mapping::MapReader>(file);
    T_map_room = FindMap(*map, simulator::MakePath(scene)).Inverse();
  }

  simulator::Scene scene;
  std::unique_ptr<mapping::MapReader> map;
  calib::Pose2 T_map_room;
};

/// Random poses in the area that was driven through.
class Places {
 public:
  Places(const simulator::Scene& scene, unsigned seed) : area_(scene.path.area_m), random_(seed) {}

  calib::Pose2 Next() {
    std::uniform_real_distribution<double> x(area_[0], area_[2]);
    std::uniform_real_distribution<double> y(area_[1], area_[3]);
    std::uniform_real_distribution<double> yaw(-std::numbers::pi, std::numbers::pi);
    return {x(random_), y(random_), yaw(random_)};
  }
  Eigen::Vector3d Velocity() {
    std::uniform_real_distribution<double> speed(0.2, 0.8);
    std::uniform_real_distribution<double> turn(-0.4, 0.4);
    return {speed(random_), 0, turn(random_)};
  }

 private:
  std::array<double, 4> area_;
  std::mt19937 random_;
};

bool RunGlobal(const simulator::Scene& scene, const fs::path& folder) {
  const World world(scene, folder / "world.gpkg");
  Visitor visitor(AnotherRobot(scene), *world.map, world.T_map_room);
  constexpr int kPlaces = 100;
  constexpr int kFramesEach = 8;
  Places places(scene, 1);
  int right = 0;
  int wrong = 0;
  std::vector<double> search_ms;
  std::vector<double> frames_needed;
  for (int i = 0; i < kPlaces; ++i) {
    visitor.SwitchOn();
    const auto drive = Drive(
        places.Next(), places.Velocity(), kFramesEach, kPeriod_s, visitor.GetRenderer().GetScene());
    int frames = 0;
    bool found = false;
    for (const simulator::Frame& frame : drive) {
      const Visit visit = visitor.See(frame);
      ++frames;
      if (i > 0) search_ms.push_back(visit.milliseconds);  // the first one waits for the index
      if (!visit.location.Placed()) continue;
      found = true;
      (Right(visit) ? right : wrong) += 1;
      frames_needed.push_back(frames);
      if (!Right(visit)) fmt::print("place {}: off by {:.3f} m\n", i, visit.error_m);
      break;
    }
    if (!found) {
      const calib::Pose2 at = Planar(drive.front().T_map_base);
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

bool RunJumps(const simulator::Scene& scene, const fs::path& folder) {
  const World world(scene, folder / "world.gpkg");
  Visitor visitor(AnotherRobot(scene), *world.map, world.T_map_room);
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
    for (const simulator::Frame& frame : Drive(places.Next(),
                                               places.Velocity(),
                                               kFramesEach,
                                               kPeriod_s,
                                               visitor.GetRenderer().GetScene())) {
      const Visit visit = visitor.See(frame);
      frames += found ? 0 : 1;
      if (!visit.location.Placed()) continue;
      if (!Right(visit)) {
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

bool RunPeriodic(const simulator::Scene& scene, const fs::path& folder) {
  const World world(scene, folder / "world.gpkg");
  Visitor visitor(AnotherRobot(scene), *world.map, world.T_map_room);
  constexpr int kPlaces = 20;
  constexpr int kEnough = 20;  // placed frames: it stays right
  int sure = 0;
  int wrong = 0;
  int found = 0;
  double travel_m = 0;
  std::vector<double> search_ms;
  for (int i = 0; i < kPlaces; ++i) {
    visitor.SwitchOn();
    simulator::Scene drive = visitor.GetRenderer().GetScene();
    drive.seed += static_cast<std::uint64_t>(i);  // another way each time
    drive.path.kind = simulator::PathKind::kRandomWalk;
    drive.path.length_m = 60;
    drive.path.max_frames = 400;
    int placed = 0;
    double way_m = 0;
    const std::vector<simulator::Frame> frames = simulator::MakePath(drive);
    for (std::size_t k = 0; k < frames.size() && placed < kEnough; ++k) {
      const Visit visit = visitor.See(frames[k]);
      if (placed == 0 && k > 0) {
        search_ms.push_back(visit.milliseconds);
        way_m +=
            (frames[k].T_map_base.translation() - frames[k - 1].T_map_base.translation()).norm();
      }
      if (!visit.location.Placed()) continue;
      ++sure;
      ++placed;
      if (!Right(visit)) {
        ++wrong;
        fmt::print("place {}: sure and off by {:.3f} m\n", i, visit.error_m);
      }
    }
    found += placed > 0 ? 1 : 0;
    if (placed > 0) travel_m += way_m;
    fmt::print("place {:2}: {}\n",
               i,
               placed > 0 ? fmt::format("sure after {:.1f} m", way_m)
                          : fmt::format("never sure within {:.1f} m", way_m));
    std::fflush(stdout);
  }
  fmt::print(
      "places {}, found {} after {:.1f} m (mean); a frame until then {:.0f} ms (median); frames "
      "reported as sure {}, wrong {}\n",
      kPlaces,
      found,
      found > 0 ? travel_m / found : 0,
      Median(search_ms),
      sure,
      wrong);
  return wrong == 0 && 2 * found > kPlaces;
}

/// What a drive through a mapped world came to.
struct DriveResult {
  int frames = 0;
  int placed = 0;
  int wrong = 0;
  int first = -1;  ///< placed frame
  double squares = 0;
  double largest_m = 0;
  double yaw_squares = 0;
  double nees = 0;
  double variances = 0;
  std::vector<double> frame_ms;

  void Add(const Visit& visit) {
    frame_ms.push_back(visit.milliseconds);
    ++frames;
    if (!visit.location.Placed()) return;
    if (first < 0) first = frames - 1;
    ++placed;
    wrong += Right(visit) ? 0 : 1;
    squares += visit.error_m * visit.error_m;
    yaw_squares += visit.error_rad * visit.error_rad;
    largest_m = std::max(largest_m, visit.error_m);
    nees += visit.nees;
    variances += 0.5 * visit.location.pose.covariance.topLeftCorner<2, 2>().trace();
  }
  [[nodiscard]] double Mean(double sum) const { return sum / std::max(placed, 1); }
  void Print(const std::string& name) const {
    fmt::print(
        "{:24}  {:6}  {:6}  {:5}  {:5}  {:7.3f}  {:10.3f}  {:12.4f}  {:8.3f}  {:6.2f}  {:6.1f}\n",
        name,
        frames,
        placed,
        first,
        wrong,
        1e3 * std::sqrt(Mean(squares)),
        1e3 * largest_m,
        180 / std::numbers::pi * std::sqrt(Mean(yaw_squares)),
        1e3 * std::sqrt(Mean(variances)),
        Mean(nees) / 2,
        Median(frame_ms));
    std::fflush(stdout);
  }
  static void PrintHeader() {
    fmt::print(
        "{:24}  frames  placed  first  wrong  RMSE mm  largest mm  yaw RMSE deg  sigma mm  NEES/2  "
        "ms (median)\n",
        "");
  }
};

DriveResult DriveAround(const World& world, simulator::Scene scene, double length_m) {
  scene.path.kind = simulator::PathKind::kRandomWalk;
  scene.path.length_m = length_m;
  Visitor visitor(scene, *world.map, world.T_map_room);
  DriveResult result;
  for (const simulator::Frame& frame : simulator::MakePath(scene)) result.Add(visitor.See(frame));
  return result;
}

/// A fifth of the ceiling is covered by panels that the map does not know, each of another grey.
bool RunChanged(const simulator::Scene& scene, const fs::path& folder) {
  const World world(scene, folder / "world.gpkg");
  simulator::Scene changed = AnotherRobot(scene);
  changed.path.max_frames = 600;
  Places places(scene, 4);
  constexpr double kSide_m = 1.3;
  const double area_m2 = scene.room.length_m * scene.room.width_m;
  const int panels = static_cast<int>(0.2 * area_m2 / (kSide_m * kSide_m));
  for (int i = 0; i < panels; ++i) {
    const calib::Pose2 at = places.Next();
    simulator::Box panel{.x_m = at.x, .y_m = at.y, .length_m = kSide_m, .width_m = kSide_m};
    panel.bottom_m = scene.room.height_m - 0.03;
    panel.top_m = scene.room.height_m - 0.001;
    panel.yaw_deg = 180 / std::numbers::pi * at.yaw;
    panel.brightness = 0.15 + 0.05 * (i % 8);
    changed.fixtures.boxes.push_back(panel);
  }
  DriveResult::PrintHeader();
  const DriveResult result = DriveAround(world, changed, 80);
  result.Print("a fifth changed");
  return result.wrong == 0 && result.placed > 0.9 * result.frames;
}

bool RunCameras(const simulator::Scene& scene, const fs::path& folder) {
  const World world(scene, folder / "world.gpkg");
  std::vector<std::pair<std::string, simulator::Scene>> robots;
  const auto add = [&](const std::string& name, const auto& change) {
    simulator::Scene other = AnotherRobot(scene);
    change(other.camera, other.picture);
    other.path.max_frames = 150;
    robots.emplace_back(name, other);
  };
  using simulator::Camera;
  using simulator::Picture;
  add("as in the other runs", [](Camera&, Picture&) {});
  add("wide angle", [](Camera& c, Picture&) { c.focal_px = 300; });
  add("narrow angle", [](Camera& c, Picture&) { c.focal_px = 800; });
  add("mounted at 1.2 m", [](Camera& c, Picture&) { c.mount_height_m = 1.2; });
  add("320 x 240 px", [](Camera& c, Picture&) {
    c.width_px = 320;
    c.height_px = 240;
    c.focal_px /= 2;
  });
  add("1280 x 960 px", [](Camera& c, Picture&) {
    c.width_px = 1280;
    c.height_px = 960;
    c.focal_px *= 2;
  });
  add("barrel distortion", [](Camera& c, Picture&) { c.distortion = {-0.25, 0.07, 0, 0, 0}; });
  add("mounted askew", [](Camera& c, Picture&) {
    c.mount_yaw_deg = 70;
    c.mount_pitch_deg = 3;
    c.mount_roll_deg = -2;
    c.mount_x_m = 0.2;
  });
  add("dark and noisy", [](Camera&, Picture& p) {
    p.exposure_gain = 0.15;
    p.read_noise = 0.003;
    p.shot_noise = 0.02;
  });
  add("overexposed", [](Camera&, Picture& p) { p.exposure_gain = 2.2; });
  add("smeared, 20 ms", [](Camera& c, Picture&) { c.exposure_time_s = 0.02; });
  DriveResult::PrintHeader();
  int wrong = 0;
  for (const auto& [name, robot] : robots) {
    const DriveResult result = DriveAround(world, robot, 20);
    result.Print(name);
    wrong += result.wrong;
  }
  return wrong == 0;
}

/// Ten worlds that differ in all that matters.
std::vector<simulator::Scene> TenWorlds() {
  std::vector<simulator::Scene> worlds;
  for (int i = 0; i < 10; ++i) {
    simulator::Scene scene;
    scene.seed = static_cast<std::uint64_t>(100 + i);
    scene.room = {
        .length_m = 10.0 + i % 3, .width_m = 7.0 + i % 2, .height_m = 2.5 + 0.3 * (i % 4)};
    scene.ceiling.kind =
        i % 3 == 2 ? simulator::CeilingKind::kPlaster : simulator::CeilingKind::kTiles;
    scene.ceiling.tile_length_m = i % 2 == 0 ? 0.6 : 0.5;
    scene.ceiling.tile_width_m = i % 2 == 0 ? 0.6 : 1.0;
    if (scene.ceiling.kind == simulator::CeilingKind::kTiles) {
      scene.ceiling.lamp_every_x = 4;
      scene.ceiling.lamp_every_y = 3;
      scene.ceiling.lamps_off_share = 0.1;
    }
    scene.fixtures.sprinklers_per_100m2 = 6;
    scene.fixtures.ducts_per_100m2 = i % 2;
    scene.camera.focal_px = 420 + 15 * i;
    scene.camera.mount_yaw_deg = 5 * i;
    if (i % 4 == 1) scene.camera.distortion = {-0.2, 0.05, 0, 0, 0};
    scene.path.area_m = {1.5, 1.5, scene.room.length_m - 1.5, scene.room.width_m - 1.5};
    scene.path.speed_m_s = 0.6;
    worlds.push_back(scene);
  }
  return worlds;
}

bool RunConsistency(const fs::path& folder) {
  DriveResult all;
  DriveResult::PrintHeader();
  const std::vector<simulator::Scene> worlds = TenWorlds();
  for (std::size_t i = 0; i < worlds.size(); ++i) {
    const World world(worlds[i], folder / fmt::format("world{}.gpkg", i));
    const DriveResult result = DriveAround(world, AnotherRobot(worlds[i]), 20);
    result.Print(fmt::format("world {}", i));
    all.placed += result.placed;
    all.wrong += result.wrong;
    all.nees += result.nees;
  }
  const double nees = all.Mean(all.nees) / 2;
  fmt::print("NEES / 2 over all frames {:.2f}, wrong {}\n", nees, all.wrong);
  return all.wrong == 0 && nees > 0.5 && nees < 2;
}

/// Tracking a frame costs so many times the registration of the same frames with each other.
bool RunSpeed(const fs::path& folder) {
  const simulator::Scene scene = TenWorlds()[0];
  const World world(scene, folder / "world0.gpkg");
  simulator::Scene other = AnotherRobot(scene);
  other.path.kind = simulator::PathKind::kRandomWalk;
  other.path.length_m = 15;
  const simulator::Renderer renderer(other);
  std::vector<cv::Mat> pictures;
  for (const simulator::Frame& frame : simulator::MakePath(other)) {
    pictures.push_back(renderer.Render(frame));
  }
  const auto time_ms = [&](const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
               .count() /
           static_cast<double>(pictures.size());
  };
  cv::setNumThreads(1);
  std::vector<double> ratios;
  for (int round = 0; round < 5; ++round) {
    registration::Registrar registrar(pictures[0].size());
    const double streaming_ms = time_ms([&] {
      registration::FrameSpectrum before = registrar.Analyze(pictures[0]);
      for (const cv::Mat& picture : pictures) {
        registration::FrameSpectrum now = registrar.Analyze(picture);
        (void)registrar.Register(before, now);
        before = now;
      }
    });
    localization::Localizer localizer(*world.map, *renderer.GetRig().up);
    std::int64_t index = 0;
    for (; index < 20; ++index) {  // switched on and settled
      (void)localizer.Locate({pictures[0], index, kPeriod_s * static_cast<double>(index), {}});
    }
    const double tracking_ms = time_ms([&] {
      for (const cv::Mat& picture : pictures) {
        (void)localizer.Locate({picture, index, kPeriod_s * static_cast<double>(index), {}});
        ++index;
      }
    });
    const localization::LocalizerReport& report = localizer.Report();
    ratios.push_back(tracking_ms / streaming_ms);
    fmt::print(
        "registration of each frame with the one before {:.2f} ms, tracking {:.2f} ms: {:.2f} "
        "times "
        "({} of {} frames tracked)\n",
        streaming_ms,
        tracking_ms,
        ratios.back(),
        report.tracking,
        report.frames);
  }
  fmt::print("tracking / registration: {:.2f} (median), at most 1.5\n", Median(ratios));
  return Median(ratios) <= 1.5;
}

int Run(const std::vector<std::string>& arguments) {
  const char* const usage =
      "ceilmap_localize_bench consistency|speed [-o DIR], or "
      "global|jumps|periodic|changed|cameras SCENE.yaml [-o DIR]";
  if (arguments.empty()) throw calib::InputError(usage);
  const std::string& mode = arguments[0];
  const bool needs_scene = mode != "consistency" && mode != "speed";
  const std::size_t used = needs_scene ? 2 : 1;
  const bool has_folder = arguments.size() == used + 2 && arguments[used] == "-o";
  if (arguments.size() != used && !has_folder) throw calib::InputError(usage);
  const fs::path folder = has_folder ? arguments[used + 1] : ".";
  fs::create_directories(folder);
  if (mode == "consistency") return RunConsistency(folder) ? 0 : 1;
  if (mode == "speed") return RunSpeed(folder) ? 0 : 1;
  const simulator::Scene scene = simulator::ReadScene(arguments[1]);
  if (mode == "global") return RunGlobal(scene, folder) ? 0 : 1;
  if (mode == "jumps") return RunJumps(scene, folder) ? 0 : 1;
  if (mode == "changed") return RunChanged(scene, folder) ? 0 : 1;
  if (mode == "cameras") return RunCameras(scene, folder) ? 0 : 1;
  if (mode == "periodic") return RunPeriodic(scene, folder) ? 0 : 1;
  throw calib::InputError(usage);
}

}  // namespace
}  // namespace ceilmap::bench

int main(int argc, char** argv) {
  try {
    return ceilmap::bench::Run(std::vector<std::string>(argv + 1, argv + argc));
  } catch (const std::exception& error) {
    fmt::print(stderr, "ceilmap_localize_bench: {}\n", error.what());
    return 2;
  }
}
