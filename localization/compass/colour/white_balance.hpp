#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "localization/compass/colour/colour_classes.hpp"
#include "localization/compass/colour/scan_lines.hpp"

namespace ceilmap::colour {

/// Factors of the pixel values of a camera, blue, green and red, (0, inf).
using ChannelGains = std::array<double, 3>;

/// Carries the colours of a model over to another camera: a gain per channel that makes the mean
/// colour of the camera's scan lines that of the model's classes (grey world with a known mean).
/// Figure 6 of Methenitis et al. 2013 shows such differences between the cameras of six robots.
///
/// Valid if the camera sees about the same as the model: a full turn, or much of one. A brightness
/// that is common to all channels is part of the gains.
class WhiteBalance {
 public:
  /// @param classes  Of a model.
  explicit WhiteBalance(const std::vector<ColourClass>& classes);

  /// @param samples  Samples from ScanLines::Sample.
  void Add(const cv::Mat& samples, const ScanLines& lines);
  /// @return gains in [1/3, 3]; 1 before the first Add, and for a channel that is black.
  [[nodiscard]] ChannelGains Gains() const;

 private:
  cv::Scalar model_;  // mean B, G, R
  cv::Scalar sum_;
  double count_ = 0;
};

/// Multiplies the pixel values by the gains. Values from 250 may be saturated: they become 255.
/// @param bgr  CV_8UC3.
void Apply(const ChannelGains& gains, cv::Mat& bgr);

}  // namespace ceilmap::colour
