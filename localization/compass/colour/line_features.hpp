#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "localization/compass/colour/colour_classes.hpp"
#include "localization/compass/colour/scan_lines.hpp"

namespace ceilmap::colour {

/// Features of a frame: one row per scan line with its k x k frequencies of transitions. Element i
/// k + j is the frequency of transitions from class i to class j between consecutive samples, going
/// up the line. Counts are divided by n - 1 for n samples, so that each row sums to 1, less the
/// fraction of transitions with colours of no class.
using LineFeatures = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// @param samples  Samples from ScanLines::Sample.
/// @param features  Allocated unless it already has the right size.
void CountTransitions(const cv::Mat& samples,
                      const ScanLines& lines,
                      const ColourClasses& classes,
                      LineFeatures& features);

}  // namespace ceilmap::colour
