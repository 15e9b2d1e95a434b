#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "mapping/mosaic/height_map.hpp"
#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// Small levelled copies of all images (1/8 of the side, about 5 kB each), to find where one of
/// them shows what the others do not: a person, something carried past, a wall.
class Thumbnails {
 public:
  explicit Thumbnails(cv::Size view_size) : view_size_(view_size) {}

  /// Adds the next view's image.
  void Add(const cv::Mat& image);
  /// Levels all images; to be called once. @param shading  of MakeShading.
  void Level(const std::vector<float>& gain_factors, const cv::Mat& shading);
  /// Grey value near a pixel of the full image; negative outside of the image.
  [[nodiscard]] float At(int view, const cv::Point2d& pixel) const;

 private:
  cv::Size view_size_;
  std::vector<cv::Mat> images_;
};

/// Agreement of a view with the others over a tile of the mosaic: a factor on its weights. It is 1
/// in most places, and close to 0 where the view's thumbnail differs by more than a fifth from the
/// median of at least three views, or where a nearer surface hides the place from it. Sampled on
/// cells of 8 x 8 mosaic pixels, interpolated between them.
class Agreement {
 public:
  /// Whether agreement is full over the whole tile, which is the usual case.
  [[nodiscard]] bool IsFull() const { return cells_.empty(); }
  /// Factor at a pixel of the mosaic inside the tile; only valid where IsFull() is false.
  [[nodiscard]] float At(int col, int row) const;

 private:
  friend std::vector<Agreement> CompareViews(const cv::Rect&,
                                             const store::MosaicGrid&,
                                             const std::vector<ViewPlacement>&,
                                             const std::vector<int>&,
                                             const Thumbnails&,
                                             const HeightMap&);
  cv::Point first_cell_;
  cv::Mat cells_;  // CV_32FC1
};

/// Part of the views of a place that agree on what is there, if its surface has the ratio `rho`; 1
/// where fewer than three show it. @param candidates  indices of the views.
double AgreementAt(const cv::Point2d& p_map,
                   float rho,
                   const std::vector<ViewPlacement>& views,
                   const std::vector<int>& candidates,
                   const Thumbnails& thumbnails);

/// @param candidates  indices of the views that may touch the tile.
/// @return one for each candidate.
std::vector<Agreement> CompareViews(const cv::Rect& tile,
                                    const store::MosaicGrid& grid,
                                    const std::vector<ViewPlacement>& views,
                                    const std::vector<int>& candidates,
                                    const Thumbnails& thumbnails,
                                    const HeightMap& heights);

}  // namespace ceilmap::mosaic
