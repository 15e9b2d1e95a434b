#include "calib/camera.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::calib {
namespace {

/// Whether the distorted radius increases monotonically from the axis to r. Its derivative by r is
/// a cubic in s = r^2, whose minimum over [0, r^2] lies at an end or where its own derivative is
/// zero.
bool RadiusGrowsUpTo(double r2, double k1, double k2, double k3) {
  const auto slope = [&](double s) { return 1 + s * (3 * k1 + s * (5 * k2 + s * 7 * k3)); };
  if (!(slope(r2) > 0)) return false;
  const double a = 21 * k3;  // d slope / ds = a s^2 + b s + c
  const double b = 10 * k2;
  const double c = 3 * k1;
  const double discriminant = b * b - 4 * a * c;
  if (discriminant < 0) return true;
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  for (const double s : {q / a, c / q}) {  // not finite where that root does not exist
    if (s > 0 && s < r2 && !(slope(s) > 0)) return false;
  }
  return true;
}

}  // namespace

bool PinholeCamera::IsDistorted() const {
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0; });
}

std::optional<Eigen::Vector2d> PinholeCamera::Project(const Eigen::Vector3d& p_cam) const {
  if (!(p_cam.z() > 0)) return std::nullopt;
  const double x = p_cam.x() / p_cam.z();
  const double y = p_cam.y() / p_cam.z();
  if (!IsDistorted()) return Eigen::Vector2d(fx * x + cx, fy * y + cy);
  const auto& [k1, k2, p1, p2, k3] = distortion;
  const double r2 = x * x + y * y;
  if (!RadiusGrowsUpTo(r2, k1, k2, k3)) return std::nullopt;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double x_d = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double y_d = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return Eigen::Vector2d(fx * x_d + cx, fy * y_d + cy);
}

}  // namespace ceilmap::calib
