#pragma once

#include <opencv2/core.hpp>

#include "calib/base/pose2.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// Pixels of a mosaic and their position.
struct Mosaic {
  cv::Mat grey;   ///< CV_8UC1, as `alpha`, of the grid's size
  cv::Mat alpha;  ///< 0: never observed
  store::MosaicGrid grid;
};

/// A rough mosaic of a running recording, for the live page. The newest image is on top, and poses
/// are those at the time of the image. The final mosaic is rendered at the end from all poses.
/// Memory and time do not grow with the area: when it becomes too large its resolution is halved.
class LiveMosaic {
 public:
  /// @param view  of the camera; must outlive this. @param max_px  longest side, >= 512.
  explicit LiveMosaic(const calib::CeilingView& view, int max_px = 1600);

  /// @param rectified  CV_8UC1 of the view's size. About a millisecond.
  void Add(const cv::Mat& rectified, const Pose2& T_map_base);

  /// Empty before the first Add.
  [[nodiscard]] Mosaic Copy() const;

 private:
  [[nodiscard]] cv::Rect WindowOf(const cv::Rect2d& extent) const;
  void MakeRoomFor(const cv::Rect2d& extent);

  const calib::CeilingView& view_;
  int max_px_;
  cv::Mat small_;
  cv::Mat small_mask_;
  cv::Mat turned_;
  cv::Mat turned_mask_;
  cv::Mat grey_;   // row 0 is the largest y, as in store::MosaicGrid
  cv::Mat alpha_;  // 255: observed
  double min_x_ = 0;
  double max_y_ = 0;
  double resolution_ = 0;  // units per pixel; 0: nothing yet
};

}  // namespace ceilmap::mosaic
