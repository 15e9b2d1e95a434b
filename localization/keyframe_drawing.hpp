#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/base/lru_cache.hpp"
#include "localization/depth_drawing.hpp"
#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::localization {

/// Draws a view of a ceiling with depth from the images of the keyframes that were taken nearest to
/// it. An error of a height moves what is drawn by the distance between the two cameras times that
/// error. In the mosaic, where each place is shown from straight below, it is the distance of the
/// place from the camera instead, which is several times as long.
///
/// Not thread-safe: keeps the images used last.
class KeyframeDrawing {
 public:
  /// @param map, depth  must outlive the object. @param depth  nullptr: nothing can be drawn.
  KeyframeDrawing(const store::MapReader& map, const DepthDrawing* depth);

  /// @param view  the placement of the camera that sees `seen`. @param units_per_px  its resolution
  ///   on the reference plane.
  /// @param grey, mask  CV_8UC1 of the view's size; mask is 0 where no keyframe shows the place.
  void Draw(const mosaic::ViewPlacement& view,
            double units_per_px,
            const SeenSurface& seen,
            cv::Mat& grey,
            cv::Mat& mask);

 private:
  [[nodiscard]] std::vector<std::size_t> Nearest(const cv::Point2d& foot) const;
  [[nodiscard]] bool Shows(std::size_t keyframe,
                           const SeenSurface& seen,
                           const cv::Rect& block) const;
  [[nodiscard]] cv::Mat ImageOf(std::size_t keyframe, int factor);

  const store::MapReader& map_;
  const DepthDrawing* depth_;
  std::vector<std::int64_t> ids_;
  std::vector<mosaic::ViewPlacement> views_;
  double span_ = 0;  // map units across the longer side of an image
  LruCache<cv::Mat> images_;
  int factor_ = 1;  // of the images
};

}  // namespace ceilmap::localization
