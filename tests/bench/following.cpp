#include "tests/bench/following.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "mapping/registration/registrar.hpp"
#include "tests/bench/median.hpp"
#include "tests/bench/visit.hpp"

namespace fs = std::filesystem;

namespace ceilmap::bench {
namespace {

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
    wrong += visit.Right() ? 0 : 1;
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
  Visitor visitor(scene, world);
  DriveResult result;
  for (const simulator::Frame& frame : simulator::MakePath(scene))
    result.Add(visitor.Locate(frame));
  return result;
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

}  // namespace

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

bool RunChanged(const simulator::Scene& scene, const fs::path& folder) {
  const World world(scene, folder / "world.gpkg");
  simulator::Scene changed = AnotherRobot(scene);
  changed.path.max_frames = 600;
  Places places(scene, 4);
  constexpr double kSide_m = 1.3;
  const double area_m2 = scene.room.length_m * scene.room.width_m;
  const int panels = static_cast<int>(0.2 * area_m2 / (kSide_m * kSide_m));
  for (int i = 0; i < panels; ++i) {
    const Pose2 at = places.Next();
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
    change(other.camera, other.image);
    other.path.max_frames = 150;
    robots.emplace_back(name, other);
  };
  using simulator::Camera;
  using simulator::Image;
  add("as in the other runs", [](Camera&, Image&) {});
  add("wide angle", [](Camera& c, Image&) { c.focal_px = 300; });
  add("narrow angle", [](Camera& c, Image&) { c.focal_px = 800; });
  add("mounted at 1.2 m", [](Camera& c, Image&) { c.mount_height_m = 1.2; });
  add("320 x 240 px", [](Camera& c, Image&) {
    c.width_px = 320;
    c.height_px = 240;
    c.focal_px /= 2;
  });
  add("1280 x 960 px", [](Camera& c, Image&) {
    c.width_px = 1280;
    c.height_px = 960;
    c.focal_px *= 2;
  });
  add("barrel distortion", [](Camera& c, Image&) { c.distortion = {-0.25, 0.07, 0, 0, 0}; });
  add("mounted askew", [](Camera& c, Image&) {
    c.mount_yaw_deg = 70;
    c.mount_pitch_deg = 3;
    c.mount_roll_deg = -2;
    c.mount_x_m = 0.2;
  });
  add("dark and noisy", [](Camera&, Image& p) {
    p.exposure_gain = 0.15;
    p.read_noise = 0.003;
    p.shot_noise = 0.02;
  });
  add("overexposed", [](Camera&, Image& p) { p.exposure_gain = 2.2; });
  add("smeared, 20 ms", [](Camera& c, Image&) { c.exposure_time_s = 0.02; });
  DriveResult::PrintHeader();
  int wrong = 0;
  for (const auto& [name, robot] : robots) {
    const DriveResult result = DriveAround(world, robot, 20);
    result.Print(name);
    wrong += result.wrong;
  }
  return wrong == 0;
}

bool RunSpeed(const fs::path& folder) {
  const simulator::Scene scene = TenWorlds()[0];
  const World world(scene, folder / "world0.gpkg");
  simulator::Scene other = AnotherRobot(scene);
  other.path.kind = simulator::PathKind::kRandomWalk;
  other.path.length_m = 15;
  const simulator::Renderer renderer(other);
  std::vector<cv::Mat> images;
  for (const simulator::Frame& frame : simulator::MakePath(other)) {
    images.push_back(renderer.Render(frame));
  }
  const auto time_ms = [&](const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
               .count() /
           static_cast<double>(images.size());
  };
  cv::setNumThreads(1);
  std::vector<double> ratios;
  for (int round = 0; round < 5; ++round) {
    registration::Registrar registrar(images[0].size());
    const double streaming_ms = time_ms([&] {
      registration::FrameSpectrum before = registrar.Analyze(images[0]);
      for (const cv::Mat& image : images) {
        registration::FrameSpectrum now = registrar.Analyze(image);
        (void)registrar.Register(before, now);
        before = now;
      }
    });
    localization::Localizer localizer(*world.map, *renderer.GetRig().up);
    std::int64_t index = 0;
    for (; index < 20; ++index) {  // switched on and settled
      (void)localizer.Locate({images[0], index, kPeriod_s * static_cast<double>(index), {}});
    }
    const double tracking_ms = time_ms([&] {
      for (const cv::Mat& image : images) {
        (void)localizer.Locate({image, index, kPeriod_s * static_cast<double>(index), {}});
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

}  // namespace ceilmap::bench
