#include <algorithm>
#include <cmath>

#include "samples/simulator/structure_run.hpp"

namespace ceilmap::simulator {
namespace {

constexpr double kHousing = 0.2;  // brightness

void BuildPendant(StructureRun& run, double s) {
  const Structure& of = run.Of();
  const double c = run.Across();
  const double low = of.height_m;
  run.Cylinder({s, c, low}, {s, c, low + 0.02}, of.width_m, of.brightness);
  run.Cylinder({s, c, low + 0.015}, {s, c, low + 0.05}, 1.15 * of.width_m, kHousing);
  run.Cylinder({s, c, low + 0.05}, {s, c, low + of.depth_m}, 0.6 * of.width_m, kHousing);
  run.Hanger(s, c, low + of.depth_m);
  run.Point(s, c, low);
}

void BuildTube(StructureRun& run, double s) {
  const Structure& of = run.Of();
  const double c = run.Across();
  const double low = of.height_m;
  const double length = of.length_m / 2;
  const double half = of.width_m / 2;
  run.Block(s - length, s + length, c - half, c + half, low, low + of.depth_m, of.brightness);
  run.Block(s - length - 0.03,
            s + length + 0.03,
            c - half - 0.01,
            c + half + 0.01,
            low + 0.4 * of.depth_m,
            low + of.depth_m + 0.01,
            kHousing);
  for (const double end : {-length, length}) {
    run.Hanger(s + 0.8 * end, c, low + of.depth_m);
    for (const double side : {-half, half}) run.Point(s + end, c + side, low);
  }
}

void BuildSkylight(StructureRun& run, double s) {
  constexpr double kFrame = 0.06;
  constexpr double kBar = 0.03;
  const Structure& of = run.Of();
  const double c = run.Across();
  const double low = of.height_m;
  const double high = low + of.depth_m;
  const double length = of.length_m / 2;
  const double half = of.width_m / 2;
  run.Block(s - length, s + length, c - half, c + half, low + 0.01, high, of.brightness);
  for (const double side : {-1.0, 1.0}) {
    const double at = c + side * half;
    run.Block(s - length, s + length, at - kFrame / 2, at + kFrame / 2, low, high, kHousing);
    const double end = s + side * length;
    run.Block(end - kFrame / 2, end + kFrame / 2, c - half, c + half, low, high, kHousing);
    run.Point(s + length, at, low);
    run.Point(s - length, at, low);
  }
  const auto panes = std::max(1, static_cast<int>(std::lround(of.length_m)));
  for (int i = 1; i < panes; ++i) {
    const double at = s + length * (2.0 * i / panes - 1);
    run.Block(at - kBar / 2, at + kBar / 2, c - half, c + half, low, low + 0.01, kHousing);
  }
}

}  // namespace

void BuildSingle(StructureRun& run, double s) {
  switch (run.Of().kind) {
    case StructureKind::kPendant:
      return BuildPendant(run, s);
    case StructureKind::kTube:
      return BuildTube(run, s);
    default:
      return BuildSkylight(run, s);
  }
}

}  // namespace ceilmap::simulator
