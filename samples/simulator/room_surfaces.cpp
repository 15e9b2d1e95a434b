#include "samples/simulator/room_surfaces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ceilmap::simulator {

using Eigen::Vector3d;

RoomSurfaces::RoomSurfaces(const Scene& scene)
    : room_(scene.room), wall_(scene.seed), posters_(scene), floor_(scene.seed) {}

Hit RoomSurfaces::Trace(const Vector3d& from,
                        const Vector3d& d,
                        double pixel_span,
                        double& distance) const {
  const std::array<double, 3> far{d.x() > 0 ? room_.length_m : 0.0,
                                  d.y() > 0 ? room_.width_m : 0.0,
                                  d.z() > 0 ? room_.height_m : 0.0};
  int axis = 0;
  distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double t = (far.at(i) - from[i]) / d[i];
    if (t > 0 && t < distance) {
      distance = t;
      axis = i;
    }
  }
  if (axis < 2) return TraceWall(axis, d[axis] > 0, from + distance * d);
  if (d.z() > 0) return {0, kCeiling};
  // At a flat angle, a pixel covers more of the floor.
  const double footprint = distance * pixel_span * d.norm() / std::abs(d.z());
  return {FloorLight(from + distance * d, footprint), kFloor};
}

Hit RoomSurfaces::TraceWall(int axis, bool far, const Vector3d& at) const {
  const double shade = axis == 0 ? 1 : 0.85;
  const float texture = wall_.At(at[1 - axis] + 1.7 * axis, at.z());
  double light = room_.wall_brightness * shade * (1 + room_.wall_contrast * texture);
  const int wall = 2 * axis + (far ? 1 : 0);
  int surface = kWalls + wall;
  if (const auto field = posters_.At(wall, at[1 - axis], at.z())) {
    light *= field->brightness;
    surface = kPosters + field->index % kMaxPosterFields;
  }
  return {static_cast<float>(std::max(0.0, light)), static_cast<std::uint16_t>(surface)};
}

float RoomSurfaces::FloorLight(const Vector3d& at, double footprint_m) const {
  if (room_.floor_contrast == 0) return static_cast<float>(room_.floor_brightness);
  const double texture = floor_.At(at.x(), at.y(), footprint_m);
  return static_cast<float>(
      std::max(0.0, room_.floor_brightness * (1 + room_.floor_contrast * texture)));
}

float RoomSurfaces::SolidLight(const SolidInView& solid,
                               const Vector3d& from_camera,
                               int face) const {
  const Vector3d at = solid.InSolid(from_camera);
  const float light = solid.Light(at, face);
  if (solid.Contrast() == 0) return light;
  const Eigen::Vector2d on_face = solid.OnFace(at, face);
  return std::max(0.0F, light * (1 + solid.Contrast() * wall_.At(on_face.x(), on_face.y())));
}

}  // namespace ceilmap::simulator
