#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "localization/depth_drawing.hpp"
#include "mapping/registration/registrar.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::localization {

/// A piece of the map as seen by the camera of the robot being localized.
struct Patch {
  Pose2 T_map_base;                      ///< pose of the robot that would see it
  registration::FrameSpectrum spectrum;  ///< its blocks are prepared when it is first used
  double content = 0;                    ///< mapped fraction of it, 0..1
};

/// Draws pieces of a map's mosaic for a camera of another height, focal length and image size, so
/// that its frames can be registered with them at scale 1. Patches are drawn at the points of a
/// lattice of places and headings and are kept with their spectra, so that they are available again
/// when a robot stays, turns or returns. Cost of a new patch for 640 x 480 px: reading a window of
/// the map (GDAL keeps the tiles used last), one warp, one Analyze: about 10 ms.
///
/// The mosaic is used instead of the nearest keyframe image: it fills the patch to its corners for
/// a camera at any height, and is as exact. On a map with heights the nearest keyframes are used
/// (KeyframeDrawing): a patch shows each surface where a camera of this height sees it, and has the
/// heights of what it shows.
class MapPatches {
 public:
  /// @param map, view, depth, registrar  Must outlive the object.
  /// @param view  View of the robot being localized, in the map's unit of length.
  /// @param depth  of the same view; nullptr: the ceiling is taken to be one plane.
  /// @param looks  of the map, in another light. Not used on a map with heights.
  MapPatches(const store::MapReader& map,
             const calib::CeilingView& view,
             registration::Registrar& registrar,
             const DepthDrawing* depth = nullptr,
             std::vector<store::Look> looks = {});
  ~MapPatches();

  /// In which light patches are drawn from now on: that of the mosaic, or that of the looks.
  void SetOtherLight(bool other);
  /// Whether the view from this pose looks otherwise in the other light.
  [[nodiscard]] bool DependsOnLight(const Pose2& T_map_base) const;

  /// The patch whose lattice point is nearest to a pose; null where too little is mapped.
  [[nodiscard]] std::shared_ptr<const Patch> Near(const Pose2& T_map_base);

  /// The patch as seen from exactly this pose; not kept. Null as Near.
  [[nodiscard]] std::shared_ptr<const Patch> Exactly(const Pose2& T_map_base);

  /// Draws the view from exactly this pose.
  /// @param grey, mask  CV_8UC1 of the view's size; mask is 0 where nothing is mapped, grey has no
  ///   meaning there.
  /// @return inverse height ratio of each pixel, CV_32FC1; empty on a map without heights.
  cv::Mat Draw(const Pose2& T_map_base, cv::Mat& grey, cv::Mat& mask) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::localization
