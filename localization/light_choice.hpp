#pragma once

#include <opencv2/core.hpp>

namespace ceilmap::localization {

/// In which of two lights a robot sees the ceiling: that of the map's mosaic, or the other one that
/// the map has looks of. Images of known pose vote; two more votes for one light decide.
class LightChoice {
 public:
  /// @param image, in_map_light, in_other_light  CV_8UC1 of one size: what the robot saw, and the
  /// map as seen from there in both lights. @param content  Where the map has content, CV_8UC1.
  /// Only pixels around those in which the lights differ are compared (by correlation, so that the
  /// exposure does not matter); no vote where these are too few, or fit both lights alike.
  void Add(const cv::Mat& image,
           const cv::Mat& in_map_light,
           const cv::Mat& in_other_light,
           const cv::Mat& content);
  void Forget() { votes_ = 0; }

  [[nodiscard]] bool IsKnown() const;
  [[nodiscard]] bool IsOther() const { return votes_ > 0; }

 private:
  int votes_ = 0;  // > 0: for the other light
};

}  // namespace ceilmap::localization
