#pragma once

#include <opencv2/core.hpp>

namespace ceilmap::registration {

/// The image without single white or black pixels (defective ones, errors of transmission), if it
/// has more than one in two thousand: they are noise of all frequencies, far stronger than the
/// sensor's, and a thousandth of them hides a ceiling's grain. Judged by a twelfth of the pixels; a
/// median of 3x3 pixels takes them out.
/// @param grey  CV_8UC1. @param buffer  takes the result when there are any.
/// @return `grey` or `buffer`.
const cv::Mat& WithoutImpulses(const cv::Mat& grey, cv::Mat& buffer);

}  // namespace ceilmap::registration
