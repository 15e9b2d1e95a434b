#include "calib/lens_range.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::calib {
namespace {

constexpr double kMaxRadius = 100;  // 89.4 deg from the axis
constexpr double kStep = 1.005;

double Distorted(const PinholeCamera& camera, double r) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double s = r * r;
  return r * (1 + s * (k1 + s * (k2 + s * k3)));
}

/// The first interval of the increasing part in which the distorted radius reaches a value.
struct Bracket {
  double low = 0;
  double high = 0;
  bool reached = false;
};

Bracket FindRadius(const PinholeCamera& camera, double distorted) {
  Bracket bracket;
  double before = 0;
  for (double r = 1e-3; r < kMaxRadius; r *= kStep) {
    const double now = Distorted(camera, r);
    if (!(now > before)) return bracket;
    bracket.high = r;
    if (now >= distorted) {
      bracket.reached = true;
      return bracket;
    }
    bracket.low = r;
    before = now;
  }
  return bracket;
}

}  // namespace

std::optional<double> UndistortedRadius(const PinholeCamera& camera, double distorted) {
  if (!camera.IsDistorted()) return distorted;
  Bracket bracket = FindRadius(camera, distorted);
  if (!bracket.reached) return std::nullopt;
  constexpr int kSteps = 50;
  for (int i = 0; i < kSteps; ++i) {
    const double middle = (bracket.low + bracket.high) / 2;
    (Distorted(camera, middle) < distorted ? bracket.low : bracket.high) = middle;
  }
  return bracket.high;
}

double CornerRadius(const PinholeCamera& camera) {
  const double x = std::max(std::abs(camera.cx), std::abs(camera.width_px - 1 - camera.cx));
  const double y = std::max(std::abs(camera.cy), std::abs(camera.height_px - 1 - camera.cy));
  return std::hypot(x / camera.fx, y / camera.fy);
}

double ValidRatio(const PinholeCamera& camera) {
  if (!camera.IsDistorted()) return 1;
  const double corner = CornerRadius(camera);
  const Bracket bracket = FindRadius(camera, corner);
  return bracket.reached ? 1 : Distorted(camera, bracket.low) / corner;
}

}  // namespace ceilmap::calib
