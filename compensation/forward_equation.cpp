#include "compensation/forward_equation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/base/degrees.hpp"
#include "calib/base/field_check.hpp"
#include "compensation/bracketed_root.hpp"

namespace ceilmap::compensation {
namespace {

constexpr double kCellRad = kRadPerDeg;
constexpr double kSameRootRad = 1e-12;
constexpr double kTouch = 1e-15;  // a minimum this close to zero is a root
constexpr double kNoSlope = 1e-9;

/// Argument of the minimum of |function|, which falls at `low` and rises at `high`.
template <typename Function>
double Valley(const Function& function, double low, double high) {
  const double falls = function(low).slope;
  while (true) {
    const double middle = low + 0.5 * (high - low);
    if (!(middle > low && middle < high)) return middle;
    (function(middle).slope * falls > 0 ? low : high) = middle;
  }
}

/// All roots of `function` within +-range_rad, in rising order. Searches cells of at most one
/// degree. No root is missed when the slope changes its sign at most once in a cell.
template <typename Function>
std::vector<double> AllRoots(const Function& function, double range_rad) {
  std::vector<double> roots;
  const auto add = [&](double root) {
    if (roots.empty() || root - roots.back() > kSameRootRad) roots.push_back(root);
  };
  const auto add_between = [&](double low, double high) {
    add(BracketedRoot(function, low, high, 0.5 * (low + high)));
  };
  // An odd number of cells: tilt 0, the most frequent root, lies inside one.
  const int cells = 2 * static_cast<int>(std::ceil(range_rad / kCellRad)) + 1;
  double low = -range_rad;
  ValueAndSlope at_low = function(low);
  for (int i = 1; i <= cells; ++i) {
    const double high = range_rad * (2.0 * i / cells - 1);
    const ValueAndSlope at_high = function(high);
    if (at_low.value * at_high.value <= 0) {
      add_between(low, high);
    } else if (at_low.value * at_low.slope < 0 && at_high.value * at_high.slope > 0) {
      const double valley = Valley(function, low, high);
      const double depth = function(valley).value;
      if (depth * at_low.value <= 0) {
        add_between(low, valley);
        add_between(valley, high);
      } else if (std::abs(depth) <= kTouch) {
        add(valley);
      }
    }
    low = high;
    at_low = at_high;
  }
  return roots;
}

/// The terms of Eq. (1) at one tilt, each with its slope.
struct State {
  ValueAndSlope tan;
  ValueAndSlope base;   // b
  ValueAndSlope climb;  // z' - d

  State(const TiltModel& model, double camera_height_m, double tilt_rad, double seen_motion_m) {
    tan.value = std::tan(tilt_rad);
    tan.slope = 1 + tan.value * tan.value;
    base.value = model.BaseShift(tilt_rad, camera_height_m, seen_motion_m);
    base.slope = model.BaseShiftSlope(tilt_rad, camera_height_m);
    climb.value = model.CameraHeight(tilt_rad, camera_height_m) - camera_height_m;
    climb.slope = model.CameraHeightSlope(tilt_rad, camera_height_m);
  }
};

/// E = t - t1 (1 - b / D) - (z' - d) / D
ValueAndSlope WallResidual(const State& at, const WallObservation& seen) {
  const double parallax = seen.tan_shift * at.base.value - at.climb.value;
  const double slope = seen.tan_shift * at.base.slope - at.climb.slope;
  return {at.tan.value - seen.tan_shift + seen.wall_per_m * parallax,
          at.tan.slope + seen.wall_per_m * slope};
}

/// F = b (s t - t1) - (s - 1) (z' - d)
ValueAndSlope ZoomResidual(const State& at, const ZoomObservation& seen) {
  const double drop = seen.zoom * at.tan.value - seen.tan_shift;
  return {at.base.value * drop - (seen.zoom - 1) * at.climb.value,
          at.base.slope * drop + at.base.value * seen.zoom * at.tan.slope -
              (seen.zoom - 1) * at.climb.slope};
}

/// d(tilt) / d(input) of residual(tilt, input) = 0.
double Implicit(double by_input, double by_tilt) {
  // Below this slope two roots coincide; the remaining value is a rounding error.
  return std::abs(by_tilt) < kNoSlope ? std::numeric_limits<double>::infinity()
                                      : -by_input / by_tilt;
}

ForwardTilt FromWall(double tilt_rad, const State& at, const WallObservation& seen) {
  const double slope = WallResidual(at, seen).slope;
  ForwardSensitivity by;
  by.by_tan_shift = Implicit(seen.wall_per_m * at.base.value - 1, slope);
  by.by_wall_per_m = Implicit(seen.tan_shift * at.base.value - at.climb.value, slope);
  by.by_seen_motion_m = Implicit(seen.tan_shift * seen.wall_per_m, slope);
  return {tilt_rad, at.base.value, by};
}

ForwardTilt FromZoom(double tilt_rad, const State& at, const ZoomObservation& seen) {
  const double slope = ZoomResidual(at, seen).slope;
  ForwardSensitivity by;
  by.by_tan_shift = Implicit(-at.base.value, slope);
  by.by_zoom = Implicit(at.base.value * at.tan.value - at.climb.value, slope);
  by.by_seen_motion_m = Implicit(seen.zoom * at.tan.value - seen.tan_shift, slope);
  return {tilt_rad, at.base.value, by};
}

/// True when the wall stands in front of both cameras, and not nearer than allowed.
bool IsInFront(const ForwardTilt& tilt, double wall_per_m, const ForwardLimits& limits) {
  const double zoom = 1 / (1 - tilt.base_shift_m * wall_per_m);
  return zoom > 0 && std::max(1.0, zoom) * wall_per_m * limits.nearest_wall_m <= 1;
}

/// The tilt nearest to th1 first.
void Sort(std::vector<ForwardTilt>& tilts, double tan_shift) {
  const double th1 = std::atan(tan_shift);
  std::sort(tilts.begin(), tilts.end(), [th1](const ForwardTilt& one, const ForwardTilt& other) {
    return std::abs(one.tilt_rad - th1) < std::abs(other.tilt_rad - th1);
  });
}

ForwardVerdict VerdictOf(const std::vector<ForwardTilt>& tilts, bool any_root) {
  if (tilts.size() > 1) return ForwardVerdict::kAmbiguous;
  if (tilts.size() == 1) return ForwardVerdict::kUnique;
  return any_root ? ForwardVerdict::kImplausible : ForwardVerdict::kNoRoot;
}

}  // namespace

void ForwardLimits::Validate() const {
  const FieldCheck require("forward limits");
  require(max_tilt_rad > 0 && max_tilt_rad <= kMaxTiltRad,
          "max_tilt_rad",
          max_tilt_rad,
          "in (0, pi/4]; give radians");
  require(nearest_wall_m > 0 && std::isfinite(nearest_wall_m),
          "nearest_wall_m",
          nearest_wall_m,
          "finite and > 0");
}

std::optional<ForwardTilt> ForwardSolution::Unique() const {
  if (verdict != ForwardVerdict::kUnique) return std::nullopt;
  return tilts.front();
}

ForwardEquation::ForwardEquation(const TiltModel& model, double camera_height_m)
    : model_(model), camera_height_m_(camera_height_m) {
  (void)model_.MastLength(0, camera_height_m_);  // throws on a wrong height
}

ForwardSolution ForwardEquation::SolveFromWall(const WallObservation& seen,
                                               const ForwardLimits& limits) const {
  limits.Validate();
  if (!(std::isfinite(seen.tan_shift) && std::isfinite(seen.seen_motion_m) &&
        std::isfinite(seen.wall_per_m) && seen.wall_per_m >= 0)) {
    return {ForwardVerdict::kInvalid, {}};
  }
  const auto at = [&](double tilt_rad) {
    return State(model_, camera_height_m_, tilt_rad, seen.seen_motion_m);
  };
  const std::vector<double> roots = AllRoots(
      [&](double tilt_rad) { return WallResidual(at(tilt_rad), seen); }, limits.max_tilt_rad);
  std::vector<ForwardTilt> tilts;
  for (const double root : roots) {
    const ForwardTilt tilt = FromWall(root, at(root), seen);
    if (IsInFront(tilt, seen.wall_per_m, limits)) tilts.push_back(tilt);
  }
  Sort(tilts, seen.tan_shift);
  return {VerdictOf(tilts, !roots.empty()), tilts};
}

ForwardSolution ForwardEquation::SolveFromZoom(const ZoomObservation& seen,
                                               const ForwardLimits& limits) const {
  limits.Validate();
  if (!(std::isfinite(seen.tan_shift) && std::isfinite(seen.seen_motion_m) &&
        std::isfinite(seen.zoom) && seen.zoom > 0)) {
    return {ForwardVerdict::kInvalid, {}};
  }
  const auto at = [&](double tilt_rad) {
    return State(model_, camera_height_m_, tilt_rad, seen.seen_motion_m);
  };
  std::vector<ForwardTilt> tilts;
  for (const double root :
       AllRoots([&](double tilt_rad) { return ZoomResidual(at(tilt_rad), seen); },
                limits.max_tilt_rad)) {
    tilts.push_back(FromZoom(root, at(root), seen));
  }
  Sort(tilts, seen.tan_shift);
  return {VerdictOf(tilts, false), tilts};
}

}  // namespace ceilmap::compensation
