#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "mapping/mosaic/height_refinement.hpp"
#include "mapping/mosaic/image_cache.hpp"
#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// An image that may show a place.
struct PhotoView {
  const ViewPlacement* placement = nullptr;
  ImageCache::Image image;  ///< padded by kPadding pixels
  float gain = 1;           ///< factor that levels the image
};

/// Cost of a ratio by the images: patches of 5 x 5 samples at a place, in the up to five images in
/// which it is most central, are compared with the most central one by their levelled grey values.
/// The worst half is left out: a nearer surface may hide the place there.
class PhotoCost : public RatioCost {
 public:
  /// @param grid  of the raster. @param view_size  without padding.
  PhotoCost(std::vector<PhotoView> views,
            const store::MosaicGrid& grid,
            cv::Size view_size,
            double units_per_px);

  void Select(int col, int row, float rho) override;
  [[nodiscard]] float Cost(float rho) const override;

 private:
  std::vector<PhotoView> views_;
  store::MosaicGrid grid_;
  cv::Size view_size_;
  double units_per_px_;
  cv::Point2d at_;             // map
  std::vector<int> selected_;  // the most central first
  std::vector<std::pair<double, int>> order_;
};

}  // namespace ceilmap::mosaic
