#include "mapping/repetition.hpp"

#include <algorithm>
#include <cstring>

namespace ceilmap::mapping {
namespace {

constexpr int kBlockPx = 16;

bool IsConstant(const cv::Mat& image, int x, int y) {
  const uchar first = image.at<uchar>(y, x);
  for (int row = y; row < y + kBlockPx; ++row) {
    const auto* const pixels = image.ptr<uchar>(row) + x;
    if (!std::all_of(pixels, pixels + kBlockPx, [first](uchar p) { return p == first; })) {
      return false;
    }
  }
  return true;
}

bool IsSame(const cv::Mat& a, const cv::Mat& b, int x, int y) {
  for (int row = y; row < y + kBlockPx; ++row) {
    if (std::memcmp(a.ptr<uchar>(row) + x, b.ptr<uchar>(row) + x, kBlockPx) != 0) return false;
  }
  return true;
}

}  // namespace

double RepetitionMeter::Next(const cv::Mat& image) {
  int textured = 0;
  int repeated = 0;
  if (before_.size() == image.size()) {
    for (int y = 0; y + kBlockPx <= image.rows; y += kBlockPx) {
      for (int x = 0; x + kBlockPx <= image.cols; x += kBlockPx) {
        if (IsConstant(image, x, y)) continue;
        ++textured;
        repeated += IsSame(image, before_, x, y) ? 1 : 0;
      }
    }
  }
  image.copyTo(before_);
  return textured > 0 ? static_cast<double>(repeated) / textured : 0;
}

}  // namespace ceilmap::mapping
