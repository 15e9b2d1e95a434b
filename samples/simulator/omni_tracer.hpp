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

/// What the camera under the mirror sees, in colour: the room of RayTracer, with edges between
/// surfaces where they are within 1/12 pixel. Where steep rays would show the robot, it does: a
/// grey disc with the dark camera in its middle. Around the mirror it is dark.
class OmniTracer {
 public:
  /// @param scene  valid, with an omni camera.
  OmniTracer(const Scene& scene, std::vector<Box> boxes);

  /// The light on the pixels: CV_32FC3, blue, green, red. Its luminance is what a grey camera would
  /// see. Thread-safe.
  [[nodiscard]] cv::Mat Trace(const Eigen::Isometry3d& T_map_base,
                              const std::vector<PaintedBox>& movers) const;

 private:
  class View;  // one pose

  std::vector<Box> boxes_;
  MirrorRays rays_;
  RoomSurfaces surfaces_;
  Paints paints_;
  CeilingTexture ceiling_;
};

}  // namespace ceilmap::simulator
