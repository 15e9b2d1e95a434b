#include "samples/simulator/motion_blur.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "samples/simulator/pose_interpolation.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Length of a ray from inside the room to its hull, in lengths of `direction`.
double DistanceToHull(const Vector3d& from, const Vector3d& direction, const Room& room) {
  const Vector3d size(room.length_m, room.width_m, room.height_m);
  double distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double distance_i = ((direction[i] > 0 ? size[i] : 0.0) - from[i]) / direction[i];
    if (distance_i > 0) distance = std::min(distance, distance_i);
  }
  return distance;
}

/// The ray of a pixel, with z = 1; for wide lenses that of the last pixel on the line to it that is
/// less than 70 degrees from the axis.
Vector3d RayTowards(const calib::Lens& lens, const Vector2d& pixel) {
  constexpr double kMinDepth = 0.34;
  constexpr int kSteps = 32;
  const Vector2d centre(lens.cx, lens.cy);
  for (int step = 0; step < kSteps; ++step) {
    const double fraction = 1 - static_cast<double>(step) / kSteps;
    const auto ray = lens.Ray(centre + fraction * (pixel - centre));
    if (ray && ray->z() > kMinDepth) return *ray / ray->z();
  }
  return Vector3d::UnitZ();
}

}  // namespace

Isometry3d PoseDuring(const Exposure& exposure, double after_middle_s) {
  if (after_middle_s == 0) return exposure.T_map_base;
  const double part = after_middle_s / exposure.half_s;
  return part < 0 ? Between(exposure.T_map_base, exposure.T_map_base_open, -part)
                  : Between(exposure.T_map_base, exposure.T_map_base_close, part);
}

std::vector<Vector3d> PlaneInCorners(const calib::MountedCamera& mounted,
                                     const Isometry3d& T_map_base,
                                     double height_m) {
  const calib::Lens& camera = mounted.camera;
  const double right = camera.width_px - 1;
  const double low = camera.height_px - 1;
  const Isometry3d T_map_cam = T_map_base * mounted.T_base_cam;
  const double rise = height_m - T_map_cam.translation().z();
  std::vector<Vector3d> points_map;
  for (const Vector2d& corner :
       {Vector2d(0, 0), Vector2d(right, 0), Vector2d(0, low), Vector2d(right, low)}) {
    points_map.emplace_back(T_map_cam * (rise * RayTowards(camera, corner)));
  }
  return points_map;
}

std::vector<Vector3d> RoomInImage(const calib::MountedCamera& mounted,
                                  const Isometry3d& T_map_base,
                                  const Room& room) {
  const calib::Lens& camera = mounted.camera;
  const Isometry3d T_map_cam = T_map_base * mounted.T_base_cam;
  std::vector<Vector3d> points_map;
  for (const double u : {0.0, (camera.width_px - 1) / 2.0, camera.width_px - 1.0}) {
    for (const double v : {0.0, (camera.height_px - 1) / 2.0, camera.height_px - 1.0}) {
      const Vector3d direction = T_map_cam.linear() * RayTowards(camera, {u, v});
      const double distance = DistanceToHull(T_map_cam.translation(), direction, room);
      if (std::isfinite(distance))
        points_map.emplace_back(T_map_cam.translation() + distance * direction);
    }
  }
  return points_map;
}

double BlurLength(const calib::MountedCamera& mounted,
                  const Exposure& exposure,
                  const std::vector<Vector3d>& points_map) {
  const calib::Lens& camera = mounted.camera;
  double longest = 0;
  for (const Vector3d& p_map : points_map) {
    const auto seen_from = [&](const Isometry3d& T_map_base) {
      const Vector3d p = (T_map_base * mounted.T_base_cam).inverse() * p_map;
      return camera.Project(p);
    };
    const auto first = seen_from(exposure.T_map_base_open);
    const auto last = seen_from(exposure.T_map_base_close);
    if (first && last) longest = std::max(longest, (*last - *first).norm());
  }
  return longest;
}

std::vector<double> TimesOfBlur(double blur_px) {
  if (!(blur_px > 0.1)) return {0};
  // Two images at Gauss's points have the same spread as the whole motion, and a similar appearance
  // while they are less than a pixel apart.
  if (blur_px < 1.5) return {-1 / std::sqrt(3.0), 1 / std::sqrt(3.0)};
  const int count = std::clamp(static_cast<int>(std::ceil(blur_px / 0.75)), 3, 64);
  std::vector<double> moments(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) moments[i] = (2.0 * i + 1) / count - 1;
  return moments;
}

}  // namespace ceilmap::simulator
