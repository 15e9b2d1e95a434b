#include "mapping/registration/impulses.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace ceilmap::registration {
namespace {

bool IsImpulse(const unsigned char* above,
               const unsigned char* here,
               const unsigned char* below,
               int x) {
  constexpr int kFar = 60;  // grey levels: no lens images a dot of one pixel
  const auto [least, most] = std::minmax({above[x], below[x], here[x - 1], here[x + 1]});
  return here[x] > most + kFar || here[x] < least - kFar;
}

}  // namespace

const cv::Mat& WithoutImpulses(const cv::Mat& grey, cv::Mat& buffer) {
  constexpr int kEveryRow = 4;
  constexpr int kEveryColumn = 3;
  constexpr int kOneIn = 2000;
  int seen = 0;
  int impulses = 0;
  for (int y = 1; y + 1 < grey.rows; y += kEveryRow) {
    const auto* const above = grey.ptr<unsigned char>(y - 1);
    const auto* const here = grey.ptr<unsigned char>(y);
    const auto* const below = grey.ptr<unsigned char>(y + 1);
    for (int x = 1; x + 1 < grey.cols; x += kEveryColumn) {
      ++seen;
      impulses += IsImpulse(above, here, below, x) ? 1 : 0;
    }
  }
  if (impulses * kOneIn <= seen) return grey;
  cv::medianBlur(grey, buffer, 3);
  return buffer;
}

}  // namespace ceilmap::registration
