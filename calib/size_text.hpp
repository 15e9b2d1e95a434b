#pragma once

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <string>

namespace ceilmap::calib {

/// An image's size as messages have it: "640 x 480".
inline std::string SizeText(cv::Size size) {
  return fmt::format("{} x {}", size.width, size.height);
}

}  // namespace ceilmap::calib
