#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/mosaic/ceiling_extent.hpp"
#include "mapping/mosaic/height_map.hpp"
#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// Heights of a ceiling above the floor, for people and other programs: those of HeightMap in
/// metres, at the pixels of any grid. Where an image shows a plane ceiling (a keyframe without
/// heights), and no other image has heights, it is the height of the reference plane. What is not
/// ceiling (CeilingExtent) has no height.
class FloorHeights {
 public:
  /// @param keyframes  final poses; images are not used.
  FloorHeights(const std::vector<graph::Keyframe>& keyframes, const store::MapMetadata& metadata);

  /// Whether no keyframe has heights, or they cannot be expressed in metres.
  [[nodiscard]] bool empty() const { return heights_.empty(); }
  /// Heights at the centres of a window's pixels, metres, CV_32FC1; NaN where nothing is known. A
  /// value is that of the nearest pixel of HeightMap, and does not depend on the window.
  [[nodiscard]] cv::Mat Window(const store::MosaicGrid& grid, const cv::Rect& window) const;

 private:
  [[nodiscard]] cv::Mat PlaneMask(const store::MosaicGrid& grid, const cv::Rect& window) const;

  store::MapMetadata metadata_;
  HeightMap heights_;
  CeilingExtent ceiling_;
  std::vector<ViewPlacement> plane_views_;
};

}  // namespace ceilmap::mosaic
