#include "samples/simulator/structures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "calib/base/degrees.hpp"
#include "samples/simulator/random.hpp"
#include "samples/simulator/structure_run.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

bool Moves(const Structure& structure) {
  return structure.kind == StructureKind::kFan || structure.kind == StructureKind::kCrane;
}

bool IsSingle(StructureKind kind) {
  return kind == StructureKind::kPendant || kind == StructureKind::kTube ||
         kind == StructureKind::kSkylight || kind == StructureKind::kFan;
}

struct Extent {
  double from_m;
  double to_m;
  double across_m;  // of the room
};

Extent ExtentOf(const Structure& of, const Room& room) {
  const double along_m = of.along == Axis::kY ? room.width_m : room.length_m;
  return {of.from_m,
          of.to_m > 0 ? std::min(of.to_m, along_m) : along_m,
          of.along == Axis::kY ? room.length_m : room.width_m};
}

/// Positions of the runs across, without random deviation.
std::vector<double> RunPlaces(const Structure& of, const Room& room) {
  std::vector<double> places;
  const double end_m = ExtentOf(of, room).across_m;
  for (int i = 0; of.runs == 0 || i < of.runs; ++i) {
    const double at_m = of.at_m + i * of.spacing_m;
    if (at_m >= end_m) break;
    places.push_back(at_m);
    if (of.spacing_m <= 0) break;
  }
  return places;
}

/// Calls build(run, s) for each single object, or once with the start of each continuous run.
void ForEach(const Scene& scene,
             std::size_t index,
             Objects& objects,
             const std::function<void(StructureRun&, double)>& build) {
  const Structure& of = scene.structures[index];
  Random random(scene.seed + ((index + 1) << 40U), Purpose::kStructures);
  const Extent extent = ExtentOf(of, scene.room);
  const auto exists = [&] { return random.Uniform(0, 1) < of.share; };
  const auto deviation = [&] { return random.Uniform(-of.jitter_m, of.jitter_m); };
  for (const double at_m : RunPlaces(of, scene.room)) {
    if (!IsSingle(of.kind)) {
      const double across_m = at_m + deviation();
      if (!exists()) continue;
      StructureRun run(of, across_m, scene.room.height_m, random, objects);
      build(run, extent.from_m);
      continue;
    }
    for (const double s : PlacesBetween(extent.from_m, extent.to_m, of.every_m)) {
      const double across_m = at_m + deviation();
      const double place_m = s + deviation();
      if (!exists()) continue;
      StructureRun run(of, across_m, scene.room.height_m, random, objects);
      build(run, place_m);
    }
  }
}

void BuildFan(StructureRun& run, double s, double now_s) {
  const Structure& of = run.Of();
  const double low = of.height_m;
  const double c = run.Across();
  run.Cylinder({s, c, low}, {s, c, low + of.depth_m}, 0.18 * of.width_m, of.brightness);
  run.Hanger(s, c, low + of.depth_m);
  const double start_rad = run.Dice().Uniform(0, 2);
  const double angle_rad = start_rad + now_s * of.turn_rate_deg_s * kRadPerDeg;
  for (int i = 0; i < 4; ++i) {
    const AngleAxisd turn(angle_rad + i * std::numbers::pi / 2, Vector3d::UnitZ());
    const Vector3d out = turn * Vector3d::UnitX();
    const Vector3d hub = run.InMap(s, c, low + 0.3 * of.depth_m);
    run.BarInMap(hub + 0.08 * of.width_m * out,
                 hub + 0.5 * of.width_m * out,
                 0.12 * of.width_m,
                 0.01,
                 of.brightness);
  }
}

/// To and fro from 0 to travel_m at constant speed.
double CraneOffset(const Structure& of, double now_s) {
  if (of.travel_m <= 0) return 0;
  const double turns = of.speed_m_s * now_s / (2 * of.travel_m);
  const double fraction = 2 * (turns - std::floor(turns));
  return of.travel_m * (fraction <= 1 ? fraction : 2 - fraction);
}

void BuildCrane(StructureRun& run, double s0, double s1, double now_s) {
  const Structure& of = run.Of();
  const double c = run.Across() + CraneOffset(of, now_s);
  const double low = of.height_m;
  const double girder = of.width_m / 4;
  for (const double side : {-0.5, 0.5}) {
    const double at = c + side * (of.width_m - girder);
    run.Block(s0, s1, at - girder / 2, at + girder / 2, low, low + of.depth_m, of.brightness);
  }
  for (const double s : PlacesBetween(s0, s1, of.every_m)) {  // ties between the girders
    run.Block(s - 0.04,
              s + 0.04,
              c - of.width_m / 2 + girder,
              c + of.width_m / 2 - girder,
              low + 0.05,
              low + 0.1,
              0.5 * of.brightness);
  }
  const double hoist = s0 + 0.4 * (s1 - s0);
  run.Block(hoist - 0.25,
            hoist + 0.25,
            c - 0.2,
            c + 0.2,
            low - 0.05,
            low + of.depth_m,
            1.6 * of.brightness);
}

}  // namespace

void AddStructures(const Scene& scene, Objects& objects) {
  for (std::size_t i = 0; i < scene.structures.size(); ++i) {
    const Structure& of = scene.structures[i];
    if (Moves(of)) continue;
    const double end_m = ExtentOf(of, scene.room).to_m;
    ForEach(scene, i, objects, [&](StructureRun& run, double s) {
      IsSingle(of.kind) ? BuildSingle(run, s) : BuildContinuous(run, s, end_m);
    });
  }
}

std::vector<Solid> MovingStructures(const Scene& scene, double now_s) {
  Objects objects;
  for (std::size_t i = 0; i < scene.structures.size(); ++i) {
    const Structure& of = scene.structures[i];
    if (!Moves(of)) continue;
    const double end_m = ExtentOf(of, scene.room).to_m;
    ForEach(scene, i, objects, [&](StructureRun& run, double s) {
      of.kind == StructureKind::kFan ? BuildFan(run, s, now_s) : BuildCrane(run, s, end_m, now_s);
    });
  }
  return objects.solids;
}

double NearestHeight(const Scene& scene) {
  double height_m = scene.room.height_m;
  for (const Structure& of : scene.structures) {
    if (of.height_m > scene.camera.mount_height_m + 0.1) {
      height_m = std::min(height_m, of.height_m);
    }
  }
  return height_m;
}

double MovingBlurLength(const Scene& scene, const Camera& camera) {
  double longest_px = 0;
  for (const Structure& of : scene.structures) {
    if (!Moves(of)) continue;
    const double speed_m_s = of.kind == StructureKind::kFan
                                 ? std::abs(of.turn_rate_deg_s) * kRadPerDeg * of.width_m / 2
                                 : of.speed_m_s;
    const double distance_m = std::max(0.1, of.height_m - camera.mount_height_m);
    longest_px =
        std::max(longest_px, speed_m_s * camera.exposure_time_s * camera.focal_px / distance_m);
  }
  return longest_px;
}

double CountSolids(const Structure& of, const Room& room) {
  const Extent extent = ExtentOf(of, room);
  const double length_m = std::max(0.0, extent.to_m - extent.from_m);
  double runs = of.spacing_m > 0 ? 1 + std::max(0.0, extent.across_m - of.at_m) / of.spacing_m : 1;
  if (of.runs > 0) runs = std::min<double>(runs, of.runs);
  constexpr double kMaxInOne = 20;  // solids of a single object, a panel or a detail
  double parts = 1 + length_m / of.every_m + of.details_per_10m * length_m / 10;
  if (of.hanger_every_m > 0) parts += length_m / of.hanger_every_m;
  if (of.kind == StructureKind::kTray) parts += of.width_m / 0.02 * (1 + length_m / 1.7);
  return runs * parts * kMaxInOne;
}

}  // namespace ceilmap::simulator
