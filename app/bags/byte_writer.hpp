#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace ceilmap::bags {

/// Appends the bytes of a number, the least significant first.
template <typename Number>
requires std::is_arithmetic_v<Number>
void AppendLittleEndian(Number number, std::vector<std::uint8_t>& bytes) {
  if constexpr (std::same_as<Number, double>) {
    AppendLittleEndian(std::bit_cast<std::uint64_t>(number), bytes);
  } else if constexpr (std::same_as<Number, float>) {
    AppendLittleEndian(std::bit_cast<std::uint32_t>(number), bytes);
  } else {
    const auto bits = static_cast<std::make_unsigned_t<Number>>(number);
    for (std::size_t i = 0; i < sizeof(Number); ++i) {
      bytes.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
    }
  }
}

inline void AppendBytes(std::span<const std::uint8_t> from, std::vector<std::uint8_t>& bytes) {
  bytes.insert(bytes.end(), from.begin(), from.end());
}

}  // namespace ceilmap::bags
