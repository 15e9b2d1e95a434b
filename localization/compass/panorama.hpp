#pragma once

#include <opencv2/core.hpp>

namespace ceilmap::compass {

/// Panoramas here show the full circle, one column per 360/W deg, and azimuth falls from left to
/// right: what stands left of the robot is at the left of what stands ahead. They are CV_8UC1 or
/// CV_8UC3, 2 to kMaxColumns wide.
inline constexpr int kMaxColumns = 16384;

/// @param name  what the panorama is called in messages.
/// @throws InputError on a panorama that is empty, of another type, or too wide.
void CheckPanorama(const cv::Mat& panorama, const char* name);

/// @throws InputError also when the two differ in size or type.
void CheckPanoramas(const cv::Mat& reference, const cv::Mat& current);

}  // namespace ceilmap::compass
