#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

/// Internal to the registrar.
namespace ceilmap::registration {

/// What distinguishes one place of a periodic ceiling from the next: an image minus its periodic
/// part, which is at each pixel the median of the image's copies shifted by its periods. All
/// CV_32FC1 of the image's size, grey levels; NaN where nothing can be said.
struct AperiodicPart {
  cv::Mat residual;  ///< image minus periodic part
  /// Its grain alone: without large things, without the lines of the grid, slow changes removed.
  cv::Mat grain;
  /// CV_8UC1, 255 on things that stick out of the grain and are smaller than a tile, as spots and
  /// stains are.
  cv::Mat marks;
  /// CV_8UC1, 255 on all other things that stick out: lamps and vents fill tiles of the grid, and
  /// their like may be anywhere else in it. Also what the border of the image cuts.
  cv::Mat panels;
  float deviation = 0;  ///< typical deviation of the residual, grey levels; NaN: nothing is left
};

/// @param image  CV_32FC1, local mean removed; NaN where it has no content.
/// @param periods  pixels; not empty.
AperiodicPart SplitAperiodic(const cv::Mat& image, const std::vector<Eigen::Vector2d>& periods);

/// Length of the shortest period. @param periods  not empty.
double ShortestOf(const std::vector<Eigen::Vector2d>& periods);

/// The image moved by a shift: the result at x is the image at x + shift. Bicubic; NaN outside.
cv::Mat ShiftedBy(const cv::Mat& image, const Eigen::Vector2d& shift);

/// Standard deviation of a normal distribution with the median absolute value of the image
/// (CV_32FC1), without NaN; NaN if there is nothing else.
float TypicalDeviation(const cv::Mat& image);

}  // namespace ceilmap::registration
