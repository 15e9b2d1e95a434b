#include "calib/mirror.hpp"

#include <cmath>

namespace ceilmap::calib {
namespace {

/// Tolerance of the rim for rounding in a data sheet.
constexpr double kRimTolerance = 1e-6;

}  // namespace

// Points of the upper sheet have a distance of C/A z - A to the focus at +C and of C/A z + A to the
// focus at -C. Along a ray from either focus, z is linear in the distance, so the equation is
// linear.
std::optional<Eigen::Vector3d> HyperbolicMirror::Reflection(
    const Eigen::Vector3d& direction_cam) const {
  const double steepness = A_m - C_m * direction_cam.z();
  if (!(steepness > 0)) return std::nullopt;  // steeper than the asymptotes
  const double distance_m = B_m * B_m / steepness;
  const Eigen::Vector3d from_viewpoint = distance_m * direction_cam;
  if (from_viewpoint.head<2>().norm() > rim_radius_m * (1 + kRimTolerance)) return std::nullopt;
  return from_viewpoint + Eigen::Vector3d(0, 0, 2 * C_m);
}

double HyperbolicMirror::RimElevation() const {
  const double z_m = A_m * std::hypot(1, rim_radius_m / B_m);
  return std::atan2(z_m - C_m, rim_radius_m);
}

double HyperbolicMirror::CameraSlope(double elevation_rad) const {
  const double sine = std::sin(elevation_rad);
  const double distance_m = B_m * B_m / (A_m - C_m * sine);
  return distance_m * std::cos(elevation_rad) / (2 * C_m + distance_m * sine);
}

double HyperbolicMirror::Elevation(double camera_slope) const {
  const double angle_rad = std::atan(camera_slope);
  const double distance_m = B_m * B_m / (C_m * std::cos(angle_rad) - A_m);
  return std::atan2(distance_m * std::cos(angle_rad) - 2 * C_m, distance_m * std::sin(angle_rad));
}

}  // namespace ceilmap::calib
