#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <vector>

#include "samples/simulator/ceiling_texture.hpp"
#include "samples/simulator/mirror_rays.hpp"
#include "samples/simulator/movers.hpp"
#include "samples/simulator/paints.hpp"
#include "samples/simulator/room_surfaces.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// The image of the camera under the mirror, in colour: the room of RayTracer, with edges between
/// surfaces accurate to 1/12 pixel. Steep rays show the robot: a grey disc with the dark camera in
/// its middle. Outside the mirror it is dark.
class OmniTracer {
 public:
  /// @param scene  valid, with an omni camera.
  OmniTracer(const Scene& scene, std::vector<Solid> solids);

  /// The light on the pixels: CV_32FC3, blue, green, red. Its luminance is that of a grey camera.
  /// Thread-safe.
  [[nodiscard]] cv::Mat Trace(const Eigen::Isometry3d& T_map_base,
                              const std::vector<PaintedSolid>& movers) const;

 private:
  class View;  // one pose

  std::vector<Solid> solids_;
  MirrorRays rays_;
  RoomSurfaces surfaces_;
  Paints paints_;
  CeilingTexture ceiling_;
};

}  // namespace ceilmap::simulator
