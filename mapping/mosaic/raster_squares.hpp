#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

/// The squares of a raster that has content in few places. Keys of hash maps; a square's position
/// is its column and row among the squares, which may be negative. Internal.
namespace ceilmap::mosaic::squares {

inline constexpr int kSide = 32;  ///< pixels

/// The square, along one axis, that contains a pixel.
inline int Of(int pixel) {
  return pixel >= 0 ? pixel / kSide : -((kSide - 1 - pixel) / kSide);
}

inline std::int64_t Key(int x, int y) {
  return std::int64_t{y} * (std::int64_t{1} << 32) + x;
}

/// The square of a key.
inline cv::Point At(std::int64_t key) {
  const auto x = static_cast<std::int32_t>(key & 0xffffffff);
  return {x, static_cast<int>((key - x) / (std::int64_t{1} << 32))};
}

}  // namespace ceilmap::mosaic::squares
