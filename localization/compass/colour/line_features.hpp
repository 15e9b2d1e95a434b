#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "localization/compass/colour/colour_classes.hpp"
#include "localization/compass/colour/scan_lines.hpp"

namespace ceilmap::colour {

/// What a frame shows: a row per scan line with its k x k frequencies of transitions, from class i
/// to class j at element i k + j, one sample to the next going up the line; counts divided by n - 1
/// for n samples, so that each row sums to 1, less the part of colours that are of no class.
using LineFeatures = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// @param samples  of ScanLines::Sample. @param features  allocated unless it fits.
void CountTransitions(const cv::Mat& samples,
                      const ScanLines& lines,
                      const ColourClasses& classes,
                      LineFeatures& features);

}  // namespace ceilmap::colour
