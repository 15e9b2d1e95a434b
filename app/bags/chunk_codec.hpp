#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "app/bags/byte_file.hpp"

namespace ceilmap::bags {

/// The most that a chunk or a message may have, uncompressed.
inline constexpr std::uint64_t kMaxChunkBytes = std::uint64_t{512} << 20U;

enum class Compression : std::uint8_t { kNone, kZstd, kLz4, kBz2 };

/// By its name in files: "" or "none", "zstd", "lz4", "bz2".
std::optional<Compression> CompressionNamed(std::string_view name);
/// "none", "zstd", "lz4", "bz2".
std::string_view NameOf(Compression compression);

/// Decompresses one frame.
/// @param size  what it must have uncompressed, at most kMaxChunkBytes. Memory is taken as far as
///   bytes come.
/// @param unpacked  of `size` bytes; fewer where the input is damaged or ends early.
/// @return false then.
/// @throws DamagedBytes when no input of this length can have this size.
bool Decompress(Compression compression,
                std::span<const std::uint8_t> packed,
                std::uint64_t size,
                Buffer& unpacked);

/// True of the first bytes of a zstd frame (RFC 8878, 3.1.1), which no serialized message begins
/// with.
bool IsZstd(std::span<const std::uint8_t> bytes);

/// Decompresses a message that rosbag2 compressed by itself: one zstd frame that states its size.
/// @throws DamagedBytes
void DecompressMessage(std::span<const std::uint8_t> packed, Buffer& unpacked);

}  // namespace ceilmap::bags
