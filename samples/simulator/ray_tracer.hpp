#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "samples/simulator/camera_rays.hpp"
#include "samples/simulator/ceiling_texture.hpp"
#include "samples/simulator/movers.hpp"
#include "samples/simulator/paints.hpp"
#include "samples/simulator/room_surfaces.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// What a camera anywhere in the room sees: the ceiling, the walls and what hangs on them, the
/// floor, and boxes with parallax and side faces. Rays are straight and surfaces shine by
/// themselves, the same in every direction. Edges between surfaces lie where they are within 1/100
/// pixel.
class RayTracer {
 public:
  /// @param texel_m  distance of the ceiling's samples, best half a pixel's footprint.
  /// @param saturation  of the colours; 0: a grey camera.
  RayTracer(const Scene& scene, std::vector<Box> boxes, double texel_m, double saturation = 0);

  /// The light on the pixels, 0 where the lens shows nothing: CV_32FC1 of a grey camera; else
  /// CV_32FC3, blue, green, red, whose luminance is what a grey camera would see. Thread-safe.
  /// @param movers  boxes that are there now, beside those of the constructor; with colours of
  ///   their own whatever the saturation.
  [[nodiscard]] cv::Mat Trace(const CameraRays& rays,
                              const Eigen::Isometry3d& T_map_cam,
                              const std::vector<PaintedBox>& movers = {}) const;

  [[nodiscard]] const std::vector<Box>& Boxes() const { return boxes_; }

 private:
  class View;  // one camera pose

  std::vector<Box> boxes_;
  RoomSurfaces surfaces_;
  std::optional<Paints> paints_;  // of a camera that sees colours
  CeilingTexture ceiling_;
};

}  // namespace ceilmap::simulator
