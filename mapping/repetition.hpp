#pragma once

#include <opencv2/core.hpp>

namespace ceilmap::mapping {

/// A larger share of repeated blocks (RepetitionMeter) leaves too little that is new: the image
/// does not tell where it was taken.
inline constexpr double kMaxRepeated = 0.5;

/// Finds what a codec copies from one image to the next. Below a certain bitrate, an encoder leaves
/// out the changes of weak texture: the decoder repeats the pixels of the image before, at the same
/// position in the image, while the robot moves on. Sensor noise makes such copies impossible in
/// images that were not encoded.
class RepetitionMeter {
 public:
  /// @param image  CV_8UC1, as the camera took it, not rectified.
  /// @return share, 0..1, of its blocks of 16 x 16 px that are bit by bit those of the image
  /// before; blocks without texture are not counted. 0 for the first image and after a change of
  /// size. Fast: a block that is new differs within its first row.
  double Next(const cv::Mat& image);

 private:
  cv::Mat before_;
};

}  // namespace ceilmap::mapping
