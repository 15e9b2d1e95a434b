#include "samples/simulator/solid.hpp"

#include <cmath>

#include "calib/base/degrees.hpp"

namespace ceilmap::simulator {

using Eigen::Vector3d;

Solid SolidOf(const Box& box, double contrast) {
  Solid solid;
  solid.T_map_solid.translation() = Vector3d(box.x_m, box.y_m, 0);
  solid.T_map_solid.rotate(Eigen::AngleAxisd(box.yaw_deg * kRadPerDeg, Vector3d::UnitZ()));
  solid.low = {-box.length_m / 2, -box.width_m / 2, box.bottom_m};
  solid.high = {box.length_m / 2, box.width_m / 2, box.top_m};
  solid.brightness = box.brightness;
  solid.contrast = contrast;
  return solid;
}

Solid Bar(const Vector3d& from_map, const Vector3d& to_map, double width_m, double depth_m) {
  const Vector3d along = to_map - from_map;
  const Vector3d x = along.normalized();
  const bool vertical = std::hypot(x.x(), x.y()) < 1e-6;
  const Vector3d y = vertical ? Vector3d::UnitY() : Vector3d::UnitZ().cross(x).normalized();
  Solid solid;
  solid.T_map_solid.translation() = (from_map + to_map) / 2;
  solid.T_map_solid.linear() << x, y, x.cross(y);
  solid.high = Vector3d(along.norm(), width_m, depth_m) / 2;
  solid.low = -solid.high;
  return solid;
}

Solid Rod(const Vector3d& from_map, const Vector3d& to_map, double diameter_m) {
  Solid solid = Bar(from_map, to_map, diameter_m, diameter_m);
  solid.is_round = true;
  return solid;
}

Vector3d Corner(const Solid& solid, int index) {
  const Vector3d corner((index & 1) != 0 ? solid.high.x() : solid.low.x(),
                        (index & 2) != 0 ? solid.high.y() : solid.low.y(),
                        (index & 4) != 0 ? solid.high.z() : solid.low.z());
  return solid.T_map_solid * corner;
}

Eigen::AlignedBox3d Bounds(const Solid& solid) {
  Eigen::AlignedBox3d bounds;
  for (int i = 0; i < 8; ++i) bounds.extend(Corner(solid, i));
  return bounds;
}

}  // namespace ceilmap::simulator
