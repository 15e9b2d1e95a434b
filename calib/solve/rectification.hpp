#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "calib/lens.hpp"

namespace ceilmap::calibration {

/// fx, fy, cx, cy of a camera without distortion whose image of the same size contains only content
/// of the original image; of a fisheye at most 140 degrees of it.
std::array<double, 4> RectifiedPinhole(const calib::Lens& lens);

/// The image of a lens without distortion, with RectifiedPinhole.
cv::Mat Rectify(const calib::Lens& lens, const cv::Mat& image);

}  // namespace ceilmap::calibration
