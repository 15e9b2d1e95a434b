#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "samples/simulator/camera_rays.hpp"
#include "samples/simulator/ceiling_texture.hpp"
#include "samples/simulator/deck_ribs.hpp"
#include "samples/simulator/movers.hpp"
#include "samples/simulator/paints.hpp"
#include "samples/simulator/room_surfaces.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// Accuracy of edges between surfaces: 1/100 or 1/40 pixel.
enum class EdgeQuality { kFine, kCoarse };

/// The image of a camera anywhere in the room: the ceiling, the walls with their posters, the
/// floor, and boxes with parallax and side faces. Rays are straight and surfaces emit the same
/// light in every direction.
class RayTracer {
 public:
  /// @param texel_m  Distance of the ceiling's samples, best half of a pixel's footprint.
  /// @param saturation  Of the colours; 0: a grey camera.
  RayTracer(const Scene& scene, std::vector<Solid> solids, double texel_m, double saturation = 0);

  /// The light on the pixels, 0 outside the lens's field of view: CV_32FC1 of a grey camera; else
  /// CV_32FC3, blue, green, red, whose luminance is that of a grey camera. Thread-safe.
  /// @param movers  Boxes at that moment, in addition to those of the constructor; always with
  /// their own colours. @param rows  Of the image; the content of others is not defined.
  [[nodiscard]] cv::Mat Trace(const CameraRays& rays,
                              const Eigen::Isometry3d& T_map_cam,
                              const std::vector<PaintedSolid>& movers = {},
                              EdgeQuality edges = EdgeQuality::kFine,
                              cv::Range rows = cv::Range::all()) const;

  [[nodiscard]] const std::vector<Solid>& Solids() const { return solids_; }

 private:
  class View;  // one camera pose

  std::vector<Solid> solids_;
  std::vector<Eigen::AlignedBox3d> bounds_;  // of solids_
  RoomSurfaces surfaces_;
  std::optional<Paints> paints_;  // of a colour camera
  CeilingTexture ceiling_;
  DeckRibs ribs_;
};

}  // namespace ceilmap::simulator
