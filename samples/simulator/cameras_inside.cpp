#include "samples/simulator/cameras_inside.hpp"

#include <fmt/format.h>

#include "calib/base/error.hpp"

namespace ceilmap::simulator {
namespace {

template <typename AnyCamera>
void CheckInside(const Scene& scene,
                 const AnyCamera& camera,
                 const Frame& frame,
                 const std::string& source) {
  const Eigen::Vector3d p =
      frame.T_map_base * Eigen::Vector3d(camera.mount_x_m, camera.mount_y_m, camera.mount_height_m);
  const Room& room = scene.room;
  const bool inside = p.x() > 0 && p.x() < room.length_m && p.y() > 0 && p.y() < room.width_m &&
                      p.z() > 0 && p.z() < room.height_m;
  if (inside) return;
  throw InputError(
      fmt::format("{}: at {:.6f} s the camera at ({:.3f}, {:.3f}, {:.3f}) must be inside of the "
                  "room of {:g} x {:g} x {:g} m",
                  source,
                  frame.stamp_s,
                  p.x(),
                  p.y(),
                  p.z(),
                  room.length_m,
                  room.width_m,
                  room.height_m));
}

}  // namespace

void CheckCamerasInside(const Scene& scene, const Frame& frame, const std::string& source) {
  CheckInside(scene, scene.camera, frame, source);
  if (scene.forward) CheckInside(scene, *scene.forward, frame, source);
  if (scene.omni) CheckInside(scene, *scene.omni, frame, source);
}

}  // namespace ceilmap::simulator
