#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>

#include "calib/ceiling_view.hpp"
#include "mapping/registration/registrar.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::localization {

struct PatchParams {
  /// Distance of the poses for which patches are drawn, part of the shorter side of what the camera
  /// sees, (0, 1).
  double spacing_ratio = 0.2;
  int headings = 16;         ///< drawn of each place, [4, 360]
  double min_content = 0.3;  ///< patches of which less is mapped are of no use, (0, 1]
  int kept = 16;             ///< patches in memory, about 4 MB each for 640 x 480 px, >= 2

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// A piece of the map as the visitor's camera would see it.
struct Patch {
  Pose2 T_map_base;                      ///< of the visitor that would see it
  registration::FrameSpectrum spectrum;  ///< its blocks are prepared when it is first used
  double content = 0;                    ///< mapped part of it, 0..1
};

/// Draws pieces of a map's mosaic for a camera of another height, focal length and image size, so
/// that its frames can be registered with them at scale 1. Patches are drawn at the points of a
/// lattice of places and headings and kept with their spectra, so that a robot that stays, turns
/// or comes back finds them ready. Cost of a new one for 640 x 480 px: reading a window of the map
/// (GDAL keeps the tiles used last), one warp, one Analyze: about 10 ms.
///
/// The mosaic and not the nearest keyframe image, because that fills the patch to its corners
/// from any height, and is as exact (0.10 and 0.12 mm RMS on rendered recordings).
///
/// Not thread-safe.
class MapPatches {
 public:
  /// @param map, view, registrar  must outlive the object. @param view  of the visitor, in the
  /// map's unit of length.
  MapPatches(const store::MapReader& map,
             const calib::CeilingView& view,
             registration::Registrar& registrar,
             const PatchParams& params = {});
  ~MapPatches();

  /// The patch whose lattice point is nearest to a pose; null where too little is mapped.
  [[nodiscard]] std::shared_ptr<const Patch> Near(const Pose2& T_map_base);

  /// Draws what a visitor at exactly this pose would see. @param grey, mask  CV_8UC1 of the view's
  /// size; mask 0 where nothing is mapped, grey there means nothing.
  void Draw(const Pose2& T_map_base, cv::Mat& grey, cv::Mat& mask) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::localization
