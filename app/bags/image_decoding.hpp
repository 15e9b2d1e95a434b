#pragma once

#include <opencv2/core.hpp>

#include "app/bags/messages.hpp"

namespace ceilmap::bags {

/// Decodes the pixels of a message: mono8, mono16, rgb8, bgr8, rgba8, bgra8, yuv422 (UYVY),
/// yuv422_yuy2, bayer_{rggb,bggr,gbrg,grbg}{8,16}, 8UC1, 8UC3, 16UC1.
/// @param colour  true: CV_8UC3 (BGR); false: CV_8UC1. 16 bits are rounded to 8 once.
/// @param image  the result; its memory is reused.
/// @throws MessageError on an unknown encoding (named, with those that are known), or when the data
///   are too short for the size.
void DecodePixels(const ImageMessage& message, bool colour, cv::Mat& image);
/// The same of JPEG and PNG.
void DecodePixels(const CompressedImageMessage& message, bool colour, cv::Mat& image);

}  // namespace ceilmap::bags
