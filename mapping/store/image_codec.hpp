#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace ceilmap::store {

/// A CV_8UC1 image as PNG: lossless, at the fast end of the compression range.
/// @throws RunError when it cannot be encoded.
std::vector<unsigned char> EncodeImage(const cv::Mat& image);

/// The opposite. Thread-safe.
/// @param size  what the image must measure: checked in the PNG's header before anything of that
///   size is allocated, so that a hostile file cannot ask for more.
/// @throws InputError (without the file's name) when the data is no such image.
cv::Mat DecodeImage(const std::vector<unsigned char>& png, cv::Size size);

}  // namespace ceilmap::store
