#include <algorithm>
#include <cmath>
#include <vector>

#include "samples/simulator/structure_run.hpp"

namespace ceilmap::simulator {
namespace {

/// s0, s1 and equal steps between them, each about `every_m`.
std::vector<double> Steps(double s0, double s1, double every_m) {
  const auto count = std::max(1, static_cast<int>(std::lround((s1 - s0) / every_m)));
  std::vector<double> steps;
  for (int i = 0; i <= count; ++i) steps.push_back(s0 + (s1 - s0) * i / count);
  return steps;
}

/// Positions of hangers, half a distance from the run's ends.
std::vector<double> HangerPlaces(const Structure& structure, double s0, double s1) {
  if (structure.hanger_every_m <= 0) return {};
  return PlacesBetween(s0, s1, structure.hanger_every_m);
}

/// Random positions of details.
std::vector<double> DetailPlaces(StructureRun& run, double s0, double s1) {
  const auto count = std::lround(run.Of().details_per_10m * (s1 - s0) / 10);
  std::vector<double> places;
  for (long i = 0; i < count; ++i) places.push_back(run.Dice().Uniform(s0, s1));
  return places;
}

/// A rod on both sides of a duct or tray, and a bar below it. Its ends are known points.
void HangInTrapeze(StructureRun& run, double s, double low_m, double high_m) {
  constexpr double kBar = 0.04;
  const double c = run.Across();
  const double half = run.Of().width_m / 2 + 0.05;
  run.Block(s - kBar / 2, s + kBar / 2, c - half, c + half, low_m - kBar, low_m, 0.3);
  for (const double side : {-1.0, 1.0}) {
    run.Hanger(s, c + side * (half - 0.02), high_m);
    run.Point(s, c + side * half, low_m - kBar);
  }
}

void BuildTruss(StructureRun& run, double s0, double s1) {
  const Structure& of = run.Of();
  const double c = run.Across();
  const double chord = std::clamp(of.width_m / 4, 0.03, 0.12);
  const double thin = 0.5 * chord;
  const double side_m = of.width_m / 2 - chord / 2;
  const double low = of.height_m;
  const double high = of.height_m + of.depth_m - chord;
  const std::vector<double> nodes = Steps(s0, s1, of.every_m);
  for (const double side : {-side_m, side_m}) {
    for (const double z : {low, high}) {
      run.Block(s0, s1, c + side - chord / 2, c + side + chord / 2, z, z + chord, of.brightness);
    }
  }
  const double low_axis = low + chord / 2;
  const double high_axis = high + chord / 2;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const bool rises = i % 2 == 0;
    for (const double side : {-side_m, side_m}) {
      run.Beam({nodes[i], c + side, rises ? low_axis : high_axis},
               {nodes[i + 1], c + side, rises ? high_axis : low_axis},
               thin,
               thin,
               of.brightness * 1.4);
    }
    const double turned = rises ? side_m : -side_m;
    run.Beam({nodes[i], c - turned, low_axis},
             {nodes[i + 1], c + turned, low_axis},
             thin,
             thin,
             of.brightness * 1.2);
  }
  // Plates under the nodes, of different sizes.
  constexpr double kPlate = 0.008;
  for (std::size_t i = 1; i + 1 < nodes.size(); ++i) {
    const double half = run.Dice().Uniform(0.05, 0.13);
    const double side = i % 2 == 0 ? -side_m : side_m;
    run.Block(nodes[i] - half,
              nodes[i] + half,
              c + side - 0.8 * chord,
              c + side + 0.8 * chord,
              low - kPlate,
              low,
              of.brightness * run.Dice().Uniform(0.7, 3));
    run.Point(nodes[i], c + side, low - kPlate);
  }
}

/// An outlet: a dark plate with bright slats, or a label.
void AddOutletOrLabel(StructureRun& run, double s, double low_m, double width_m) {
  const double c = run.Across() + run.Dice().Uniform(-0.2, 0.2) * width_m;
  const double size = run.Dice().Uniform(0.25, 0.45) * width_m;
  if (run.Dice().Uniform(0, 1) < 0.5) {  // a label
    run.Block(s - 0.5 * size,
              s + 0.5 * size,
              c - 0.25 * size,
              c + 0.25 * size,
              low_m - 0.004,
              low_m,
              run.Dice().Uniform(0.05, 0.9));
    return;
  }
  run.Block(s - size / 2, s + size / 2, c - size / 2, c + size / 2, low_m - 0.01, low_m, 0.03);
  constexpr int kSlats = 5;
  for (int i = 0; i < kSlats; ++i) {
    const double at = s + size * ((i + 0.5) / kSlats - 0.5);
    run.Block(at - 0.06 * size,
              at + 0.06 * size,
              c - 0.45 * size,
              c + 0.45 * size,
              low_m - 0.02,
              low_m - 0.01,
              0.5);
  }
}

void BuildDuct(StructureRun& run, double s0, double s1) {
  constexpr double kRim = 0.02;  // flanges are that much larger
  const Structure& of = run.Of();
  const double c = run.Across();
  const double half = of.width_m / 2;
  const double low = of.height_m;
  const double high = of.height_m + of.depth_m;
  const std::vector<double> flanges = Steps(s0, s1, of.every_m);
  for (std::size_t i = 0; i + 1 < flanges.size(); ++i) {
    run.Block(flanges[i], flanges[i + 1], c - half, c + half, low, high, of.brightness);
  }
  for (const double s : flanges) {
    const double s_low = std::max(s0, s - 0.02);
    const double s_high = std::min(s1, s + 0.02);
    run.Block(s_low,
              s_high,
              c - half - kRim,
              c + half + kRim,
              low - kRim,
              high + kRim,
              of.brightness * run.Dice().Uniform(0.6, 1.5));
    run.Point(s_low, c - half - kRim, low - kRim);
    run.Point(s_low, c + half + kRim, low - kRim);
  }
  for (const double s : DetailPlaces(run, s0, s1)) AddOutletOrLabel(run, s, low, of.width_m);
  for (const double s : HangerPlaces(of, s0, s1)) HangInTrapeze(run, s, low, low);
}

void BuildRoundDuct(StructureRun& run, double s0, double s1) {
  constexpr double kRim = 0.012;
  const Structure& of = run.Of();
  const double c = run.Across();
  const double axis = of.height_m + of.width_m / 2;
  const std::vector<double> bands = Steps(s0, s1, of.every_m);
  for (std::size_t i = 0; i + 1 < bands.size(); ++i) {
    run.Cylinder({bands[i], c, axis}, {bands[i + 1], c, axis}, of.width_m, of.brightness);
  }
  for (const double s : bands) {
    const double s_low = std::max(s0, s - 0.02);
    run.Cylinder({s_low, c, axis},
                 {std::min(s1, s + 0.02), c, axis},
                 of.width_m + 2 * kRim,
                 of.brightness * run.Dice().Uniform(0.6, 1.5));
    run.Point(s_low, c, of.height_m - kRim);
  }
  for (const double s : DetailPlaces(run, s0, s1)) {
    AddOutletOrLabel(run, s, of.height_m, 0.7 * of.width_m);
  }
  for (const double s : HangerPlaces(of, s0, s1)) run.Hanger(s, c, axis);
}

void BuildTray(StructureRun& run, double s0, double s1) {
  constexpr double kRail = 0.025;
  const Structure& of = run.Of();
  const double c = run.Across();
  const double half = of.width_m / 2;
  const double low = of.height_m;
  for (const double side : {-1.0, 1.0}) {
    const double rail = c + side * (half - kRail / 2);
    run.Block(
        s0, s1, rail - kRail / 2, rail + kRail / 2, low, low + of.depth_m, of.brightness * 1.2);
  }
  for (const double s : Steps(s0, s1, of.every_m)) {
    run.Block(s - 0.015, s + 0.015, c - half, c + half, low + 0.005, low + 0.02, of.brightness);
  }
  for (double at = -half + 0.05; at < half - 0.04;) {
    const double diameter = run.Dice().Uniform(0.012, 0.04);
    if (run.Dice().Uniform(0, 1) < 0.65) {
      // In pieces that are not quite parallel.
      double offset = 0;
      const std::vector<double> bends = Steps(s0, s1, 1.7);
      const double brightness = run.Dice().Uniform(0.03, 0.5);
      for (std::size_t i = 0; i + 1 < bends.size(); ++i) {
        const double next = run.Dice().Uniform(-0.015, 0.015);
        const double axis = low + 0.02 + diameter / 2;
        run.Cylinder({bends[i], c + at + offset, axis},
                     {bends[i + 1], c + at + next, axis},
                     diameter,
                     brightness);
        offset = next;
      }
    }
    at += diameter + run.Dice().Uniform(0.005, 0.05);
  }
  for (const double s : HangerPlaces(of, s0, s1)) HangInTrapeze(run, s, low, low);
}

void BuildPipe(StructureRun& run, double s0, double s1) {
  const Structure& of = run.Of();
  const double c = run.Across();
  const double radius = of.width_m / 2;
  const double axis = of.height_m + radius;
  const double brightness = of.brightness * run.Dice().Uniform(0.6, 1.6);  // of this run's paint
  const std::vector<double> joints = Steps(s0, s1, of.every_m);
  for (std::size_t i = 0; i + 1 < joints.size(); ++i) {
    run.Cylinder({joints[i], c, axis}, {joints[i + 1], c, axis}, of.width_m, brightness);
  }
  const double rim = 0.01 + 0.1 * of.width_m;
  for (std::size_t i = 1; i + 1 < joints.size(); ++i) {
    const double half = 0.02 + 0.4 * of.width_m;
    const double s = joints[i];
    run.Cylinder({s - half, c, axis},
                 {s + half, c, axis},
                 of.width_m + 2 * rim,
                 brightness * run.Dice().Uniform(0.5, 1.6));
    run.Point(s, c, of.height_m - rim);
  }
  for (const double s : DetailPlaces(run, s0, s1)) {  // valves
    const double diameter = of.width_m + run.Dice().Uniform(0.01, 0.07);
    run.Cylinder({s, c, of.height_m - 0.02}, {s, c, axis}, diameter, run.Dice().Uniform(0.05, 0.6));
  }
  for (const double s : HangerPlaces(of, s0, s1)) run.Hanger(s, c, axis);
}

}  // namespace

void BuildContinuous(StructureRun& run, double s0, double s1) {
  switch (run.Of().kind) {
    case StructureKind::kTruss:
      return BuildTruss(run, s0, s1);
    case StructureKind::kDuct:
      return BuildDuct(run, s0, s1);
    case StructureKind::kRoundDuct:
      return BuildRoundDuct(run, s0, s1);
    case StructureKind::kTray:
      return BuildTray(run, s0, s1);
    default:
      return BuildPipe(run, s0, s1);
  }
}

}  // namespace ceilmap::simulator
