#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <unordered_map>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// Heights of the ceiling over the map, from the height fields of all keyframes: a raster of
/// inverse height ratios rho (mapping/heights/height_field.hpp; store::HeightAboveFloor converts
/// them to metres).
///
/// Each measured cell of a keyframe votes at the place in the map where its point is. The value of
/// a place is the median of the votes for one surface: the nearest (largest rho) among those with
/// at least a third of the votes of the most frequent one. Small gaps get the value of their
/// neighbours.
class HeightMap {
 public:
  HeightMap() = default;
  /// @param keyframes  final poses; images are not used.
  HeightMap(const std::vector<graph::Keyframe>& keyframes, const store::MapMetadata& metadata);

  /// Whether no keyframe has heights: the ceiling is one plane.
  [[nodiscard]] bool empty() const { return votes_.empty(); }
  /// Extent of the raster and position of its pixels, as those of a mosaic; of 0 x 0 pixels where
  /// empty. Its resolution is a quarter of the distance between the cells of the keyframes.
  [[nodiscard]] const store::MosaicGrid& Grid() const { return grid_; }
  /// rho of a window of the raster, CV_32FC1; 0 where nothing is known (the reference plane is the
  /// best guess there). A value does not depend on the window. Thread-safe.
  /// @param window  may extend beyond the grid, where nothing is known.
  [[nodiscard]] cv::Mat Ratios(const cv::Rect& window) const;

 private:
  struct Vote {
    float col;  // position in the grid; the centre of the first pixel is (0, 0)
    float row;
    float radius;  // of influence, pixels of the grid
    float rho;
    float weight;
  };

  void Add(const Vote& vote);
  [[nodiscard]] cv::Mat Elected(const cv::Rect& window) const;

  store::MosaicGrid grid_;
  std::unordered_map<std::int64_t, std::vector<Vote>> votes_;  // by square of the grid
};

}  // namespace ceilmap::mosaic
