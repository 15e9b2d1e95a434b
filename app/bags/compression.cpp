#include "app/bags/compression.hpp"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include "calib/base/error.hpp"

namespace ceilmap::bags {
namespace {

std::vector<std::uint8_t> CompressZstd(std::span<const std::uint8_t> bytes) {
  std::vector<std::uint8_t> out(ZSTD_compressBound(bytes.size()));
  const std::size_t size =
      ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), ZSTD_CLEVEL_DEFAULT);
  if (ZSTD_isError(size) != 0) throw RunError(fmt::format("zstd: {}", ZSTD_getErrorName(size)));
  out.resize(size);
  return out;
}

std::vector<std::uint8_t> CompressLz4(std::span<const std::uint8_t> bytes) {
  LZ4F_preferences_t preferences{};
  preferences.frameInfo.contentSize = bytes.size();
  std::vector<std::uint8_t> out(LZ4F_compressFrameBound(bytes.size(), &preferences));
  const std::size_t size =
      LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), &preferences);
  if (LZ4F_isError(size) != 0) throw RunError(fmt::format("lz4: {}", LZ4F_getErrorName(size)));
  out.resize(size);
  return out;
}

}  // namespace

std::vector<std::uint8_t> Compress(std::span<const std::uint8_t> bytes, Compression compression) {
  if (compression == Compression::kZstd) return CompressZstd(bytes);
  if (compression == Compression::kLz4) return CompressLz4(bytes);
  throw RunError(fmt::format("chunks cannot be compressed by {}", NameOf(compression)));
}

}  // namespace ceilmap::bags
