#include "app/bags/chunk_codec.hpp"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <new>

#include "app/bags/record_cursor.hpp"

namespace ceilmap::bags {
namespace {

struct NamedCompression {
  std::string_view name;
  // The most bytes that a byte of the input can give: of zstd a block of 128 KB that repeats one
  // byte, of lz4 a length byte, of bz2 a run of 45 MB in 40 bytes.
  std::uint64_t most_per_byte;
};
constexpr std::array<NamedCompression, 4> kCompressions = {
    {{"none", 1}, {"zstd", 32768}, {"lz4", 255}, {"bz2", 1'200'000}}};

// The memory with which decompression begins: few bytes that state a large size get a little.
std::size_t FirstSize(std::span<const std::uint8_t> packed, std::uint64_t size) {
  constexpr std::uint64_t kUsualRatio = 8;
  constexpr std::uint64_t kMin = std::uint64_t{64} << 10U;
  return static_cast<std::size_t>(std::min(size, std::max(kMin, kUsualRatio * packed.size())));
}

// True when the buffer, full, has not its final size yet, and now has room.
bool MakeLarger(Buffer& unpacked, std::uint64_t size) {
  if (unpacked.Size() >= size) return false;
  unpacked.Grow(static_cast<std::size_t>(std::min<std::uint64_t>(size, 4 * unpacked.Size())));
  return true;
}

// The size that a frame of zstd states. @throws DamagedBytes when it is another than `size`.
bool StatesItsSize(std::span<const std::uint8_t> packed, std::uint64_t size) {
  const unsigned long long frame = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (frame == ZSTD_CONTENTSIZE_ERROR || frame == ZSTD_CONTENTSIZE_UNKNOWN) return false;
  if (frame == size) return true;
  throw DamagedBytes(fmt::format("states {} bytes, but its frame {}", size, frame));
}

bool UnpackZstd(std::span<const std::uint8_t> packed, std::uint64_t size, Buffer& unpacked) {
  const bool stated = StatesItsSize(packed, size);
  unpacked.Resize(stated ? static_cast<std::size_t>(size) : FirstSize(packed, size));
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                     &ZSTD_freeDCtx);
  if (!context) throw std::bad_alloc();
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  ZSTD_outBuffer out{unpacked.Data(), unpacked.Size(), 0};
  std::size_t left = 1;
  while (left != 0) {
    const std::size_t in_before = in.pos;
    const std::size_t out_before = out.pos;
    left = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(left) != 0) break;
    if (out.pos == out.size && left != 0 && MakeLarger(unpacked, size)) {
      out = {unpacked.Data(), unpacked.Size(), out.pos};
    } else if (in.pos == in_before && out.pos == out_before) {
      break;
    }
  }
  const bool complete = left == 0 && out.pos == size;
  unpacked.Shorten(out.pos);
  return complete;
}

// The ratio is small enough to take all memory at once.
bool UnpackLz4(std::span<const std::uint8_t> packed, std::uint64_t size, Buffer& unpacked) {
  unpacked.Resize(static_cast<std::size_t>(size));
  LZ4F_dctx* created = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&created, LZ4F_VERSION)) != 0) {
    throw std::bad_alloc();
  }
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      created, &LZ4F_freeDecompressionContext);
  LZ4F_decompressOptions_t options{};
  options.stableDst = 1;  // no copy of the last 64 KB
  std::size_t written = 0;
  std::size_t left = 1;
  while (left != 0) {
    std::size_t out_size = unpacked.Size() - written;
    std::size_t in_size = packed.size();
    left = LZ4F_decompress(
        context.get(), unpacked.Data() + written, &out_size, packed.data(), &in_size, &options);
    if (LZ4F_isError(left) != 0) break;
    written += out_size;
    packed = packed.subspan(in_size);
    if (in_size == 0 && out_size == 0) break;
  }
  const bool complete = left == 0 && written == unpacked.Size();
  unpacked.Shorten(written);
  return complete;
}

bool UnpackBz2(std::span<const std::uint8_t> packed, std::uint64_t size, Buffer& unpacked) {
  unpacked.Resize(FirstSize(packed, size));
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw std::bad_alloc();
  const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> end(&stream,
                                                                       &BZ2_bzDecompressEnd);
  // The library takes what it does not change as not constant.
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(packed.data()));
  stream.avail_in = static_cast<unsigned>(packed.size());
  stream.next_out = reinterpret_cast<char*>(unpacked.Data());
  stream.avail_out = static_cast<unsigned>(unpacked.Size());
  int result = BZ_OK;
  while (result == BZ_OK) {
    const unsigned in_before = stream.avail_in;
    const unsigned out_before = stream.avail_out;
    result = BZ2_bzDecompress(&stream);
    const std::size_t written = unpacked.Size() - stream.avail_out;
    if (result == BZ_OK && stream.avail_out == 0 && MakeLarger(unpacked, size)) {
      stream.next_out = reinterpret_cast<char*>(unpacked.Data() + written);
      stream.avail_out = static_cast<unsigned>(unpacked.Size() - written);
    } else if (stream.avail_in == in_before && stream.avail_out == out_before) {
      break;
    }
  }
  const bool complete = result == BZ_STREAM_END && unpacked.Size() - stream.avail_out == size;
  unpacked.Shorten(unpacked.Size() - stream.avail_out);
  return complete;
}

}  // namespace

std::optional<Compression> CompressionNamed(std::string_view name) {
  if (name.empty()) return Compression::kNone;
  const auto* const found = std::find_if(kCompressions.begin(),
                                         kCompressions.end(),
                                         [&](const auto& known) { return known.name == name; });
  if (found == kCompressions.end()) return std::nullopt;
  return static_cast<Compression>(found - kCompressions.begin());
}

std::string_view NameOf(Compression compression) {
  return kCompressions.at(static_cast<std::size_t>(compression)).name;
}

bool Decompress(Compression compression,
                std::span<const std::uint8_t> packed,
                std::uint64_t size,
                Buffer& unpacked) {
  const std::uint64_t most =
      kCompressions.at(static_cast<std::size_t>(compression)).most_per_byte * packed.size();
  if (size > kMaxChunkBytes) {
    throw DamagedBytes(
        fmt::format("states {} MB, more than {}", size >> 20U, kMaxChunkBytes >> 20U));
  }
  if (size > most || packed.size() > std::numeric_limits<unsigned>::max()) {
    throw DamagedBytes(fmt::format(
        "states {} bytes, which {} of {} cannot hold", size, packed.size(), NameOf(compression)));
  }
  switch (compression) {
    case Compression::kZstd:
      return UnpackZstd(packed, size, unpacked);
    case Compression::kLz4:
      return UnpackLz4(packed, size, unpacked);
    case Compression::kBz2:
      return UnpackBz2(packed, size, unpacked);
    case Compression::kNone:
      break;
  }
  unpacked.Resize(static_cast<std::size_t>(size));
  std::copy_n(packed.begin(), unpacked.Size(), unpacked.Data());
  return packed.size() == size;
}

bool IsZstd(std::span<const std::uint8_t> bytes) {
  constexpr std::array<std::uint8_t, 4> kMagic = {0x28, 0xB5, 0x2F, 0xFD};
  return bytes.size() >= kMagic.size() && std::equal(kMagic.begin(), kMagic.end(), bytes.begin());
}

void DecompressMessage(std::span<const std::uint8_t> packed, Buffer& unpacked) {
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN) {
    throw DamagedBytes("is compressed but does not state its size");
  }
  if (!Decompress(Compression::kZstd, packed, size, unpacked)) {
    throw DamagedBytes("cannot be decompressed");
  }
}

}  // namespace ceilmap::bags
