#pragma once

#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/mosaic/ceiling_extent.hpp"
#include "mapping/mosaic/height_map.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

struct MosaicParams {
  /// Map units per mosaic pixel; 0: that of the keyframe images. Made coarser by a power of two
  /// where the mosaic would be too large to be stored.
  double resolution = 0;
  /// Exponent of the weight of blurred images: (sharpness of the image / that of the sharpest image
  /// of the place)^power. 0: all images have equal weight.
  double sharpness_power = 2;
  bool level_exposure = true;  ///< remove gain differences and vignetting
  /// Exclude what one image shows but most other images of the place do not (a person, something
  /// carried past, a wall): at least three images, a difference of more than a fifth from their
  /// median.
  bool reject_outliers = true;
  int cache_images = 64;  ///< decoded images kept in memory while rendering
  int threads = 0;        ///< 0: as many as the machine has cores
  /// CeilingView::Mask(): where the rectified images have content, CV_8UC1 of the view's size;
  /// empty: everywhere.
  cv::Mat view_mask;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Renders any window of the mosaic from keyframe images and poses, in memory bounded by
/// the cache (and about 10 kB for each keyframe). The constructor loads every image once.
///
/// Exposure: log I_k(u) = log E(X) + g_k + v(r), with a gain g_k per keyframe and one radial
/// vignetting profile v(r) (even polynomial, v(0) = 0) for the camera, solved by linear least
/// squares (robust: saturated and dark pixels left out, Huber) from points that several keyframes
/// observe; then each image is divided by exp(g_k + v(r)). Of a camera with a rolling shutter
/// (metadata.rig_yaml), bands of flickering lamps that images still have are solved for and
/// divided out likewise.
///
/// Heights: where keyframes have height fields, each pixel shows the surface of HeightMap at its
/// place, sampled where each image shows a point of that height. An image in which a nearer surface
/// hides the place has no weight. What is not ceiling (CeilingExtent) is left out.
class MosaicRenderer {
 public:
  /// @param keyframes  poses (images ignored), at least one.
  /// @param metadata  gives view size, units per pixel and T_base_view:
  ///   p_map = T_map_base * T_base_view * (view_units_per_px * ((u, v) - centre)).
  /// @param loader  called under a lock, one call at a time.
  MosaicRenderer(const std::vector<graph::Keyframe>& keyframes,
                 const store::MapMetadata& metadata,
                 graph::ImageLoader loader,
                 const MosaicParams& params = {});
  ~MosaicRenderer();

  /// Smallest grid that contains the ceiling on all images, with its edges on multiples of the
  /// resolution.
  [[nodiscard]] const store::MosaicGrid& Grid() const;
  /// Heights of the ceiling; empty where no keyframe has any.
  [[nodiscard]] const HeightMap& Heights() const;
  [[nodiscard]] const std::vector<store::LeftOut>& LeftOutPlaces() const;
  /// Grey as seen from above (see MosaicGrid), alpha 255 where any image sees the ceiling.
  /// Thread-safe, and uses several threads itself. The value of a point does not depend on the
  /// window.
  /// @throws InputError for a window that is empty or extends beyond the grid.
  void Render(const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::mosaic
