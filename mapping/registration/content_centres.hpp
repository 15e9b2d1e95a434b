#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace ceilmap::registration {

/// Where the content of a part of an image is: the mean place of its edges, weighted by the squares
/// of their gradients, as far as they exceed those of noise. All parts that show the same lamp have
/// their content at the lamp. The shift that such a part measures is the motion there, not at its
/// own centre: otherwise one round lamp, seen by many overlapping parts, would seem to tell a
/// rotation.
class ContentCentres {
 public:
  /// @param grey  CV_32FC1; not kept. About 0.2 ms for 160 x 120 pixels.
  explicit ContentCentres(const cv::Mat& grey);

  /// In pixels from the image's centre; the centre of the part where it shows nothing but noise.
  /// @param part  within the image.
  [[nodiscard]] Eigen::Vector2d Of(const cv::Rect& part) const;

 private:
  cv::Size size_;
  double chance_ = 0;   // weight of a pixel that counts as at the part's centre
  cv::Mat weight_;      // integral, CV_64FC1 ...
  cv::Mat weighted_x_;  // ... of the weight times the column
  cv::Mat weighted_y_;  // ... and the row
};

}  // namespace ceilmap::registration
