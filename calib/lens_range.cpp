#include "calib/lens_range.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::calib {
namespace {

constexpr double kMinRadius = 1e-3;
constexpr double kStep = 1.005;
constexpr int kSteps = 2300;  // to a radius of 96, 89.4 deg from the axis

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
  double r = kMinRadius;
  for (int step = 0; step < kSteps; ++step, r *= kStep) {
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
  constexpr int kBisections = 50;
  for (int i = 0; i < kBisections; ++i) {
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
