#pragma once

#include <cstddef>
#include <cstdint>

#include "localization/compass/panorama.hpp"

namespace ceilmap::compass {

/// Sum of squared differences of `count` bytes, at most a row of a panorama. The sum then fits 32
/// bits, which doubles the width of the vectorised loop.
inline std::uint32_t SumOfSquares(const std::uint8_t* a, const std::uint8_t* b, std::size_t count) {
  constexpr std::uint64_t kMaxChannels = 3;
  static_assert(kMaxColumns * kMaxChannels * 255 * 255 <= UINT32_MAX);
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const int difference = int{a[i]} - int{b[i]};
    sum += static_cast<std::uint32_t>(difference * difference);
  }
  return sum;
}

}  // namespace ceilmap::compass
