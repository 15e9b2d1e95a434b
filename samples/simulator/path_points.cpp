#include "samples/simulator/path_points.hpp"

#include <algorithm>
#include <cmath>

#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {
namespace {

Points Lawnmower(const Path& path) {
  const auto [x_min, y_min, x_max, y_max] = path.area_m;
  const int rows = static_cast<int>(std::floor((y_max - y_min) / path.row_spacing_m + 1e-9)) + 1;
  Points points;
  for (int row = 0; row < rows; ++row) {
    const double y = y_min + row * path.row_spacing_m;
    const bool forth = row % 2 == 0;
    points.push_back({forth ? x_min : x_max, y});
    points.push_back({forth ? x_max : x_min, y});
  }
  return points;
}

Points Loops(const Path& path) {
  const auto [x_min, y_min, x_max, y_max] = path.area_m;
  // Starts at the middle of a side, so that all four corners are equal.
  const double x_start = (x_min + x_max) / 2;
  Points points{{x_start, y_min}};
  for (int lap = 0; lap < path.laps; ++lap) {
    points.insert(points.end(), {{x_max, y_min}, {x_max, y_max}, {x_min, y_max}, {x_min, y_min}});
  }
  points.push_back({x_start, y_min});
  return points;
}

Points RandomWalk(const Path& path, std::uint64_t seed) {
  const std::array<double, 4>& area = path.area_m;
  const double min_step = std::min(area[2] - area[0], area[3] - area[1]) / 4;
  Random random(seed, Purpose::kWalk);
  const auto any_point = [&]() -> std::array<double, 2> {
    const double x = random.Uniform(area[0], area[2]);
    return {x, random.Uniform(area[1], area[3])};
  };
  Points points{any_point()};
  for (double driven = 0; driven < path.length_m;) {
    const std::array<double, 2> next = any_point();
    const double step = std::hypot(next[0] - points.back()[0], next[1] - points.back()[1]);
    if (step < min_step) continue;
    points.push_back(next);
    driven += step;
  }
  return points;
}

/// Moves each point by up to `jitter_m`, but not closer to a wall than half a metre or than it was.
void Jitter(const Scene& scene, Points& points) {
  Random random(DriveSeed(scene), Purpose::kSessionDrive);
  const std::array<double, 2> room{scene.room.length_m, scene.room.width_m};
  for (std::array<double, 2>& point : points) {
    for (std::size_t i = 0; i < 2; ++i) {
      const double gap = std::min({0.5, point.at(i), room.at(i) - point.at(i)});
      point.at(i) += scene.path.jitter_m * random.Uniform(-1, 1);
      point.at(i) = std::clamp(point.at(i), gap, room.at(i) - gap);
    }
  }
}

Points PlannedPoints(const Scene& scene) {
  switch (scene.path.kind) {
    case PathKind::kLawnmower:
      return Lawnmower(scene.path);
    case PathKind::kLoops:
      return Loops(scene.path);
    case PathKind::kRandomWalk:
      return RandomWalk(scene.path, DriveSeed(scene));
    case PathKind::kWaypoints:
    case PathKind::kTum:
      break;
  }
  return scene.path.waypoints_m;
}

}  // namespace

Points PathPoints(const Scene& scene) {
  Points points = PlannedPoints(scene);
  if (scene.path.jitter_m > 0) Jitter(scene, points);
  return points;
}

}  // namespace ceilmap::simulator
