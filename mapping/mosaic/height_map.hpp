#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/mosaic/ratio_raster.hpp"
#include "mapping/mosaic/surface_refutation.hpp"
#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// Heights of the ceiling over the map, from the height fields of all keyframes: a raster of
/// inverse height ratios rho (mapping/heights/height_field.hpp; store::HeightAboveFloor converts
/// them to metres).
///
/// Each measured cell of a keyframe votes at the place in the map where its point is. The value of
/// a place is the median of the votes for one surface: the nearest (largest rho) among those with
/// at least a third of the votes of the most frequent one. Where more keyframes see through that
/// surface, to something behind it, than confirm it, there is none: a fan that turns, or a wrong
/// measurement. Small gaps get the value of their neighbours.
class HeightMap {
 public:
  HeightMap() = default;
  /// @param keyframes  final poses; images are not used.
  /// @param threads  0: as many as the machine has cores.
  HeightMap(const std::vector<graph::Keyframe>& keyframes,
            const store::MapMetadata& metadata,
            int threads = 0);

  /// Compares the surfaces with the images, and replaces those that they refute (SettleSurfaces).
  /// @param agreement  called by several threads.
  /// @return changed places, pixels of Grid(), that no surface explains: something moves there.
  std::vector<cv::Point2d> Settle(const std::vector<graph::Keyframe>& keyframes,
                                  const store::MapMetadata& metadata,
                                  const ImageAgreement& agreement,
                                  int threads = 0);

  /// Whether no keyframe has heights: the ceiling is one plane.
  [[nodiscard]] bool empty() const { return raster_.empty(); }
  /// Extent of the raster and position of its pixels, as those of a mosaic; of 0 x 0 pixels where
  /// empty. Its resolution is a quarter of the distance between the cells of the keyframes.
  [[nodiscard]] const store::MosaicGrid& Grid() const { return raster_.Grid(); }
  /// rho of a window of the raster, CV_32FC1; 0 where nothing is known (the reference plane is the
  /// best guess there). Thread-safe.
  /// @param window  may extend beyond the grid, where nothing is known.
  [[nodiscard]] cv::Mat Ratios(const cv::Rect& window) const { return raster_.Ratios(window); }
  /// rho at a place of the map, interpolated where neighbours are of one surface; 0: not known.
  [[nodiscard]] float RatioAt(double x_map, double y_map) const;
  /// rho at the centres of a mosaic's pixels, 1 where it is not known; no matrix where all are.
  [[nodiscard]] cv::Mat RatiosOver(const cv::Rect& window, const store::MosaicGrid& mosaic) const;
  /// Smallest and largest known ratio; 1 and 1 where empty.
  [[nodiscard]] cv::Vec2f Range() const { return range_; }
  /// Whether a view sees a place: no nearer surface lies on the ray to it.
  /// @param rho  of the place.
  [[nodiscard]] bool Sees(const ViewPlacement& view, const cv::Point2d& p_map, float rho) const;

 private:
  RatioRaster raster_;
  cv::Vec2f range_{1, 1};  // of raster_
};

}  // namespace ceilmap::mosaic
