#pragma once

#include <opencv2/core.hpp>

namespace ceilmap::compass {

/// Maximum width of a panorama. Panoramas show the full circle with one column per 360/W deg.
/// Azimuth decreases from left to right: objects to the left of the robot appear to the left of
/// objects ahead. They are CV_8UC1 or CV_8UC3, 2 to kMaxColumns wide.
inline constexpr int kMaxColumns = 16384;

/// @param name  Name of the panorama in messages.
/// @throws InputError on a panorama that is empty, of another type, or too wide.
void CheckPanorama(const cv::Mat& panorama, const char* name);

/// @throws InputError also when the two differ in size or type.
void CheckPanoramas(const cv::Mat& reference, const cv::Mat& current);

}  // namespace ceilmap::compass
