#pragma once

#include <cstddef>
#include <functional>
#include <initializer_list>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ceilmap::page {

/// A picture that is encoded for a page.
struct EncodedPicture {
  std::string mime;  ///< "image/webp"; "image/png" if OpenCV has no WebP encoder
  std::vector<unsigned char> bytes;
};

/// Above 100 OpenCV's encoder of WebP keeps every pixel as it is.
inline constexpr int kLossless = 101;

/// Encodes a picture with the first of the qualities that gives at most `max_bytes`; when none
/// does, or when a side is too long for WebP, after `halve`, again and again. Internal.
/// @param picture  The picture at its present size: 8 bit, 1, 3 (blue first) or 4 channels.
/// @param halve  Reduces it to half of its size; at least 1 x 1, which is encoded in any case.
/// @param qualities  Of WebP, falling, not empty; PNG keeps every pixel.
EncodedPicture EncodeWithin(const std::function<cv::Mat()>& picture,
                            const std::function<void()>& halve,
                            std::initializer_list<int> qualities,
                            std::size_t max_bytes);

}  // namespace ceilmap::page
