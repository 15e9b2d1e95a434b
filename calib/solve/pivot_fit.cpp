#include "calib/solve/pivot_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>

#include "calib/base/degrees.hpp"
#include "calib/base/statistics.hpp"

namespace ceilmap::calibration {
namespace {

struct Point {
  double steep = 0;  // sine of the pitch, > 0
  double lift = 0;
};

// Slope of a line through the origin below the points that do not lie on it: it starts with a low
// slope, and points more than three standard deviations above the line are ignored.
std::optional<double> SlopeOf(const std::vector<Point>& points) {
  constexpr std::size_t kMin = 4;
  if (points.size() < kMin) return std::nullopt;
  std::vector<double> slopes;
  slopes.reserve(points.size());
  for (const Point& p : points) slopes.push_back(p.lift / p.steep);
  std::sort(slopes.begin(), slopes.end());
  double slope = slopes[slopes.size() / 4];
  constexpr int kRounds = 20;
  for (int round = 0; round < kRounds; ++round) {
    // The standard deviation from the points below the line, which are all inliers.
    std::vector<double> below;
    for (const Point& p : points) {
      const double off = p.lift - slope * p.steep;
      if (off <= 0) below.push_back(-off);
    }
    constexpr double kMinSigma = 2e-4;  // metres
    const double sigma = below.empty() ? kMinSigma : std::max(kMinSigma, 1.4826 * Median(below));
    double up = 0;
    double down = 0;
    for (const Point& p : points) {
      const double off = (p.lift - slope * p.steep) / (3 * sigma);
      if (std::abs(off) >= 1) continue;
      const double weight = (1 - off * off) * (1 - off * off);  // Tukey's
      up += weight * p.lift * p.steep;
      down += weight * p.steep * p.steep;
    }
    if (!(down > 0)) return std::nullopt;
    const double change = up / down - slope;
    slope = up / down;
    if (std::abs(change) < 1e-7) break;
  }
  return slope;
}

// Delete-a-group jackknife.
double SigmaOf(const std::vector<Point>& points, double slope) {
  const std::size_t groups = std::min<std::size_t>(8, points.size());
  double sum = 0;
  std::size_t used = 0;
  for (std::size_t g = 0; g < groups; ++g) {
    std::vector<Point> rest;
    rest.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (i < points.size() * g / groups || i >= points.size() * (g + 1) / groups) {
        rest.push_back(points[i]);
      }
    }
    const std::optional<double> without = SlopeOf(rest);
    if (!without) continue;
    sum += (*without - slope) * (*without - slope);
    ++used;
  }
  const auto n = static_cast<double>(used);
  return used < 2 ? std::abs(slope) : std::sqrt(sum * (n - 1) / n);
}

Pivot FitPivot(const std::vector<Point>& all) {
  Pivot pivot;
  for (const Point& p : all) pivot.max_rad = std::max(pivot.max_rad, std::asin(p.steep));
  // Near level there is only noise.
  constexpr double kMinRad = 0.4 * kRadPerDeg;
  constexpr double kMinRatio = 0.25;
  const double least = std::sin(std::max(kMinRad, kMinRatio * pivot.max_rad));
  std::vector<Point> points;
  std::copy_if(all.begin(), all.end(), std::back_inserter(points), [least](const Point& p) {
    return p.steep >= least;
  });
  const std::optional<double> slope = SlopeOf(points);
  if (!slope) return pivot;
  std::vector<Point> near;
  std::vector<double> off;
  off.reserve(points.size());
  for (const Point& p : points) off.push_back(std::abs(p.lift - *slope * p.steep));
  const double reach = std::max(6e-4, 3 * 1.4826 * Median(off));
  double squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (off[i] > reach) continue;
    near.push_back(points[i]);
    squares += off[i] * off[i];
  }
  if (near.empty()) return pivot;
  pivot.distance_m = *slope;
  pivot.sigma_m = SigmaOf(near, *slope);
  pivot.frames = static_cast<int>(near.size());
  pivot.rms_m = std::sqrt(squares / static_cast<double>(near.size()));
  return pivot;
}

// Lift of the level robot on the floor: the first frame, the reference of the lifts, has an error
// too.
double FloorOf(const std::vector<Climb>& climbs) {
  constexpr double kLevelRad = 0.2 * kRadPerDeg;
  constexpr double kLowRatio = 0.25;  // relative to the maximum: not on the step
  constexpr std::size_t kMin = 3;
  double most = 0;
  for (const Climb& climb : climbs) most = std::max(most, std::abs(climb.lift_m));
  std::vector<double> lifts;
  lifts.reserve(climbs.size());
  for (const Climb& climb : climbs) {
    if (std::abs(climb.pitch_rad) < kLevelRad && std::abs(climb.lift_m) < kLowRatio * most) {
      lifts.push_back(climb.lift_m);
    }
  }
  return lifts.size() < kMin ? 0 : Median(lifts);
}

}  // namespace

PivotFit FitPivots(const std::vector<Climb>& climbs) {
  const double floor_m = FloorOf(climbs);
  std::vector<Point> up;
  std::vector<Point> down;
  for (const Climb& climb : climbs) {
    const double steep = std::sin(climb.pitch_rad);
    if (steep < 0) up.push_back({-steep, climb.lift_m - floor_m});
    if (steep > 0) down.push_back({steep, climb.lift_m - floor_m});
  }
  return {FitPivot(up), FitPivot(down)};
}

}  // namespace ceilmap::calibration
