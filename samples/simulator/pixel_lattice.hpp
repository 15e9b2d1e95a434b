#pragma once

#include <opencv2/core.hpp>

namespace ceilmap::simulator {

/// Position i of `count` in a pixel, from its centre: a Fibonacci lattice. All u and all v are
/// different, so that the position of an edge along rows or columns is accurate to half of 1/count
/// pixel. `count` and `step` are Fibonacci numbers, `step` the second before `count` or the one
/// before.
template <int count, int step>
cv::Point2d LatticePoint(int i) {
  return {(i + 0.5) / count - 0.5, ((i * step) % count + 0.5) / count - 0.5};
}

}  // namespace ceilmap::simulator
