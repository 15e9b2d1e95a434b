#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "samples/simulator/floor_texture.hpp"
#include "samples/simulator/scene.hpp"
#include "samples/simulator/solid_in_view.hpp"
#include "samples/simulator/wall_posters.hpp"
#include "samples/simulator/wall_texture.hpp"

namespace ceilmap::simulator {

/// Numbers of surfaces; solids follow with six faces each, then the fields of posters. Two adjacent
/// surfaces have different numbers.
enum Surface : std::uint16_t {
  kCeiling = 0,
  kWalls = 1,  ///< of x = 0, then x = length, y = 0, y = width
  kFloor = 5,
  kNothing = 6,  ///< outside the field of view
  kRobot = 7,
  kSolids = 8,
  kPosters = 48100
};
constexpr int kMaxSolids = 8000;         ///< more solids reuse numbers
constexpr int kMaxPosterFields = 17000;  ///< the same

/// Surface hit by a ray.
struct Hit {
  float light = 0;
  std::uint16_t surface = kNothing;
};

/// The light of the walls, posters, floor and solids. Thread-safe.
class RoomSurfaces {
 public:
  explicit RoomSurfaces(const Scene& scene);

  /// Intersection of a ray from inside the room with its hull; for the ceiling without its light.
  /// @param direction  In map, of any length. @param pixel_span  Size of a pixel across the ray at
  /// `distance` 1, in lengths of `direction`. @param distance  To the hull, output.
  [[nodiscard]] Hit Trace(const Eigen::Vector3d& from,
                          const Eigen::Vector3d& direction,
                          double pixel_span,
                          double& distance) const;
  /// The light of a solid. @param from_camera  Vector in map from the camera to a point of the
  /// face.
  [[nodiscard]] float SolidLight(const SolidInView& solid,
                                 const Eigen::Vector3d& from_camera,
                                 int face) const;
  /// @param index  of the solid. @param face  as SolidInView::Entry.
  static std::uint16_t SolidSurface(std::size_t index, int face) {
    return static_cast<std::uint16_t>(kSolids + (index % kMaxSolids) * 6 + face);
  }
  [[nodiscard]] const Room& GetRoom() const { return room_; }

 private:
  [[nodiscard]] Hit TraceWall(int axis, bool far, const Eigen::Vector3d& at) const;
  [[nodiscard]] float FloorLight(const Eigen::Vector3d& at, double footprint_m) const;

  Room room_;
  WallTexture wall_;  // also for solids
  WallPosters posters_;
  FloorTexture floor_;
};

}  // namespace ceilmap::simulator
