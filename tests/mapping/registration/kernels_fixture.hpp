#pragma once

#include <cstddef>
#include <random>
#include <vector>

/// What the tests of the kernels share.
namespace ceilmap::registration::kernels {

inline constexpr int kW = 37;
inline constexpr int kH = 29;

inline std::size_t At(int x, int y, int w = kW) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x);
}

inline std::vector<float> RandomFloats(std::size_t n,
                                       unsigned seed,
                                       float low = -1,
                                       float high = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(low, high);
  std::vector<float> values(n);
  for (float& v : values) v = value(random);
  return values;
}

}  // namespace ceilmap::registration::kernels
