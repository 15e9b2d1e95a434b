#include "samples/simulator/path.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "calib/base/error.hpp"
#include "samples/simulator/debris.hpp"
#include "samples/simulator/drive.hpp"
#include "samples/simulator/random.hpp"
#include "samples/simulator/tum_path.hpp"

namespace ceilmap::simulator {
namespace {

using Points = std::vector<std::array<double, 2>>;

Eigen::Isometry3d OnFloor(const Pose2& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = Eigen::Vector3d(pose.x, pose.y, 0);
  return T;
}

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

Points PathPoints(const Scene& scene) {
  switch (scene.path.kind) {
    case PathKind::kLawnmower:
      return Lawnmower(scene.path);
    case PathKind::kLoops:
      return Loops(scene.path);
    case PathKind::kRandomWalk:
      return RandomWalk(scene.path, scene.seed);
    case PathKind::kWaypoints:
    case PathKind::kTum:
      break;
  }
  return scene.path.waypoints_m;
}

/// Pose of the robot, tilted over debris.
Eigen::Isometry3d BaseAt(const Scene& scene, const Drive& drive, double time_s) {
  const Pose2 T_map_axle = drive.PoseAt(time_s);
  const Tilt tilt = TiltAt(scene.debris, drive.DistanceAt(time_s));
  if (!tilt.IsLevel()) return TiltedBase(T_map_axle, tilt, scene.axle_behind_mast_m);
  return OnFloor(T_map_axle * Pose2{scene.axle_behind_mast_m, 0, 0});
}

std::vector<Frame> PlannedFrames(const Scene& scene) {
  const Path& path = scene.path;
  const Drive drive(PathPoints(scene), path);
  double count = std::ceil(drive.Duration() * path.frame_rate_hz - 1e-9) + 1;
  if (path.max_frames > 0) count = std::min(count, static_cast<double>(path.max_frames));
  if (!(count <= static_cast<double>(kMaxFrames))) {
    throw InputError(
        fmt::format("the path takes {:.0f} frames, must be at most {}; shorten it or lower "
                    "path.frame_rate_hz",
                    count,
                    kMaxFrames));
  }
  const auto pose_at = [&](double t) { return BaseAt(scene, drive, t); };
  const double half = HalfExposure(scene.camera);
  const double forward_half = scene.forward ? scene.forward->exposure_time_s / 2 : 0;
  std::vector<Frame> frames;
  frames.reserve(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(count); ++i) {
    const double t = static_cast<double>(i) / path.frame_rate_hz;
    frames.push_back({i,
                      path.start_stamp_s + t,
                      pose_at(t),
                      pose_at(t - half),
                      pose_at(t + half),
                      pose_at(t - forward_half),
                      pose_at(t + forward_half)});
  }
  return frames;
}

}  // namespace

Frame StillFrame(std::int64_t index, const Pose2& T_map_base, double stamp_s) {
  const Eigen::Isometry3d pose = OnFloor(T_map_base);
  return {index, stamp_s, pose, pose, pose, pose, pose};
}

double PathLength(const Scene& scene) {
  if (scene.path.kind == PathKind::kTum) return 0;
  const Drive drive(PathPoints(scene), scene.path);
  return drive.DistanceAt(drive.Duration());
}

std::vector<Frame> MakePath(const Scene& scene) {
  scene.Validate();
  return scene.path.kind == PathKind::kTum ? TumFrames(scene) : PlannedFrames(scene);
}

}  // namespace ceilmap::simulator
