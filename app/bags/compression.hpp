#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "app/bags/chunk_codec.hpp"

namespace ceilmap::bags {

/// Compresses to one frame that contains the size of its content.
/// @param compression  zstd or lz4.
/// @throws RunError when the library refuses.
std::vector<std::uint8_t> Compress(std::span<const std::uint8_t> bytes, Compression compression);

}  // namespace ceilmap::bags
