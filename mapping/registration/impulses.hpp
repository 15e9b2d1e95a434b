#pragma once

#include <opencv2/core.hpp>

namespace ceilmap::registration {

/// Removes single white or black pixels (defective ones, transmission errors), if there is more
/// than one in two thousand. They are noise of all frequencies, much stronger than the sensor's
/// noise; one in a thousand hides the texture of a ceiling. The decision uses a twelfth of the
/// pixels; a median of 3x3 pixels removes them.
/// @param grey  CV_8UC1. @param buffer  Receives the result if there are any.
/// @return `grey` or `buffer`.
const cv::Mat& WithoutImpulses(const cv::Mat& grey, cv::Mat& buffer);

}  // namespace ceilmap::registration
