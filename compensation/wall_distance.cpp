#include "compensation/wall_distance.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::compensation {
namespace {

constexpr double kNearestM = 0.3;

}  // namespace

WallDistance::WallDistance(double per_m, double sigma)
    : first_per_m_(per_m),
      first_variance_(sigma * sigma),
      per_m_(per_m),
      variance_(sigma * sigma) {}

void WallDistance::Learn(double zoom, double sigma_zoom, double base_shift_m) {
  // The matched objects change from frame to frame, and with them the distance: variance grows
  // slowly.
  constexpr double kForget = 0.02;  // per frame
  variance_ = std::min(first_variance_, variance_ + kForget * kForget);
  constexpr double kMinShiftM = 0.02;
  if (std::abs(base_shift_m) < kMinShiftM) return;
  // zoom = (x1 + b) / x1 = 1 + b / x1, x1 the wall's distance from the keyframe.
  const double seen = (zoom - 1) / base_shift_m;
  const double sigma = sigma_zoom / std::abs(base_shift_m);
  const double off = seen - per_m_;
  constexpr double kMaxSigmas = 4;
  const double spread = variance_ + sigma * sigma;
  if (off * off > kMaxSigmas * kMaxSigmas * spread) return;
  per_m_ += variance_ / spread * off;
  variance_ *= sigma * sigma / spread;
}

void WallDistance::MoveAhead(double metres) {
  per_m_ = PerMetre(-metres);
  // The wall may end or a door may open: the variance grows with the distance travelled.
  variance_ = std::min(first_variance_, variance_ + std::pow(0.1 * metres, 2));
}

double WallDistance::PerMetre(double base_shift_m) const {
  const double per_m = std::clamp(per_m_, 0.0, 1 / kNearestM);
  const double part = 1 + base_shift_m * per_m;  // D / x1
  return part > 0 ? std::min(per_m / part, 1 / kNearestM) : 1 / kNearestM;
}

double WallDistance::Sigma(double base_shift_m) const {
  // 1 / D = p / (1 + b p), so its derivative by p is (1 / D / p)^2 = (1 - b / D)^2.
  return std::sqrt(variance_) * std::pow(1 - base_shift_m * PerMetre(base_shift_m), 2);
}

}  // namespace ceilmap::compensation
