#include "samples/simulator/structure_run.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::simulator {
namespace {

constexpr double kHangerWidth = 0.012;  // metres

}  // namespace

std::vector<double> PlacesBetween(double s0, double s1, double every_m) {
  const double count = std::max(0.0, std::ceil((s1 - s0) / every_m - 0.5));
  std::vector<double> places(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < places.size(); ++i) {
    places[i] = s0 + (static_cast<double>(i) + 0.5) * every_m;
  }
  return places;
}

StructureRun::StructureRun(
    const Structure& structure, double across_m, double ceiling_m, Random& random, Objects& objects)
    : structure_(structure),
      across_m_(across_m),
      ceiling_m_(ceiling_m),
      random_(random),
      objects_(objects) {}

Eigen::Vector3d StructureRun::InMap(double s, double c, double z) const {
  return structure_.along == Axis::kY ? Eigen::Vector3d(c, s, z) : Eigen::Vector3d(s, c, z);
}

void StructureRun::Add(Solid solid, double brightness) {
  solid.brightness = brightness * random_.Uniform(0.92, 1.08);
  solid.contrast = structure_.contrast;
  solid.texture_offset = {random_.Uniform(0, 4), random_.Uniform(0, 4)};
  objects_.solids.push_back(std::move(solid));
}

void StructureRun::Block(
    double s0, double s1, double c0, double c1, double z0, double z1, double brightness) {
  const double c = (c0 + c1) / 2;
  const double z = (z0 + z1) / 2;
  Add(Bar(InMap(s0, c, z), InMap(s1, c, z), c1 - c0, z1 - z0), brightness);
}

void StructureRun::BarInMap(const Eigen::Vector3d& from_map,
                            const Eigen::Vector3d& to_map,
                            double width_m,
                            double depth_m,
                            double brightness) {
  Add(Bar(from_map, to_map, width_m, depth_m), brightness);
}

void StructureRun::Beam(const Eigen::Vector3d& from,
                        const Eigen::Vector3d& to,
                        double width_m,
                        double depth_m,
                        double brightness) {
  BarInMap(InMap(from.x(), from.y(), from.z()),
           InMap(to.x(), to.y(), to.z()),
           width_m,
           depth_m,
           brightness);
}

void StructureRun::Cylinder(const Eigen::Vector3d& from,
                            const Eigen::Vector3d& to,
                            double diameter_m,
                            double brightness) {
  Add(Rod(InMap(from.x(), from.y(), from.z()), InMap(to.x(), to.y(), to.z()), diameter_m),
      brightness);
}

void StructureRun::Hanger(double s, double c, double z) {
  if (ceiling_m_ - z < 0.01) return;
  Beam({s, c, z}, {s, c, ceiling_m_}, kHangerWidth, kHangerWidth, 0.25);
}

void StructureRun::Point(double s, double c, double z) {
  objects_.points.push_back({structure_.name, InMap(s, c, z)});
}

}  // namespace ceilmap::simulator
