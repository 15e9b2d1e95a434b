#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <unordered_map>

#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// Two ratios belong to one surface if they differ by no more than this part of rho.
inline constexpr float kSameSurface = 0.025F;
/// A surface hides another one if its ratio is larger by this part.
inline constexpr float kNearer = 0.05F;

/// A raster over the map of inverse height ratios rho (mapping/heights/height_field.hpp), stored as
/// squares where there is content. 0: nothing is known. Negative: a surface of this ratio was
/// measured there, and refuted.
class RatioRaster {
 public:
  RatioRaster() = default;
  /// @param grid  extent and position of the pixels, as those of a mosaic.
  explicit RatioRaster(const store::MosaicGrid& grid) : grid_(grid) {}

  /// Reserves storage for the surroundings of a pixel, from 32 to 64 pixels to each side, of
  /// content 0 where it is new.
  void AddAround(int col, int row);
  /// No storage was reserved.
  [[nodiscard]] bool empty() const { return squares_.empty(); }
  [[nodiscard]] const store::MosaicGrid& Grid() const { return grid_; }

  /// Any pixel, also beyond the grid; 0 where there is no storage.
  [[nodiscard]] float At(int col, int row) const;
  /// The pixels of a window, CV_32FC1.
  [[nodiscard]] cv::Mat Ratios(const cv::Rect& window) const;
  /// The place in the map at the centre of a pixel.
  [[nodiscard]] cv::Point2d PlaceOf(int col, int row) const;
  /// Box in the map around a window's pixels.
  [[nodiscard]] cv::Rect2d BoxOf(const cv::Rect& window) const;
  /// Smallest and largest of the positive ratios; 1 and 1 where there are none.
  [[nodiscard]] cv::Vec2f Range() const;

  /// @param window  whose content is computed; the windows of all calls cover the storage once.
  /// @param ratios  the content so far, not to be changed.
  /// @return of the window's size.
  using Work =
      std::function<cv::Mat_<float>(const cv::Rect& window, const cv::Mat_<float>& ratios)>;
  /// The raster with other content. @param threads  that call `work`; 0: as many as the machine has
  /// cores.
  [[nodiscard]] RatioRaster Transformed(int threads, const Work& work) const;

 private:
  store::MosaicGrid grid_;
  std::unordered_map<std::int64_t, cv::Mat_<float>> squares_;
};

}  // namespace ceilmap::mosaic
