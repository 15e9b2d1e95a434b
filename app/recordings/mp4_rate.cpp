#include "app/recordings/mp4_rate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string_view>

#include "calib/base/error.hpp"

namespace ceilmap::recordings {
namespace {

class Mp4File {
 public:
  explicit Mp4File(std::iostream& stream) : stream_(stream) {
    stream_.seekg(0, std::ios::end);
    size_ = stream_.tellg();
  }

  [[nodiscard]] bool Good() const { return stream_.good(); }
  [[nodiscard]] int Headers() const { return headers_; }

  // Visits the boxes of a file or a box: 32-bit size, type, content.
  void SpeedUp(double factor) { SpeedUpBoxes(0, size_, factor, 0); }

 private:
  void SpeedUpBoxes(std::int64_t begin, std::int64_t end, double factor, int depth) {
    constexpr int kDeepest = 3;  // moov, trak, mdia; a file may have any depth
    constexpr std::int64_t kHead = 8;
    for (std::int64_t at = begin; at + kHead <= end && stream_;) {
      std::int64_t size = Number(at, 4);
      const std::int64_t type = Number(at + 4, 4);
      if (size == 1) size = Number(at + kHead, 8);  // 64-bit size
      if (size == 0) size = end - at;               // up to the end
      if (size < kHead || size > end - at) return;
      if (depth < kDeepest && (Is(type, "moov") || Is(type, "trak") || Is(type, "mdia"))) {
        SpeedUpBoxes(at + kHead, at + size, factor, depth + 1);
      }
      if (Is(type, "mvhd") || Is(type, "mdhd")) SpeedUpHeader(at + kHead, factor);
      at += size;
    }
  }

  // Version (1 byte), flags, creation and modification time (4 or 8 bytes each), units per second.
  void SpeedUpHeader(std::int64_t at, double factor) {
    const std::int64_t unit_at = at + 4 + (Number(at, 1) == 1 ? 16 : 8);
    const double most = std::numeric_limits<std::uint32_t>::max();
    const double units =
        std::clamp(std::round(static_cast<double>(Number(unit_at, 4)) * factor), 1.0, most);
    const auto value = static_cast<std::uint32_t>(units);
    std::array<char, 4> bytes{};
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      bytes[i] = static_cast<char>((value >> (24 - 8 * i)) & 0xFFU);
    }
    stream_.seekp(unit_at);
    stream_.write(bytes.data(), bytes.size());
    ++headers_;
  }

  static bool Is(std::int64_t type, std::string_view name) {
    std::int64_t wanted = 0;
    for (const char c : name) wanted = 256 * wanted + c;
    return type == wanted;
  }

  // Big-endian number of the given size. Eight bytes may give a negative value, which is no valid
  // size.
  std::int64_t Number(std::int64_t at, int bytes) {
    std::uint64_t number = 0;
    stream_.seekg(at);
    for (int i = 0; i < bytes; ++i)
      number = 256 * number + (static_cast<unsigned>(stream_.get()) & 0xFFU);
    return static_cast<std::int64_t>(number);
  }

  std::iostream& stream_;
  std::int64_t size_ = 0;
  int headers_ = 0;
};

}  // namespace

bool SpeedUpMp4(std::iostream& stream, double factor) {
  Mp4File mp4(stream);
  if (mp4.Good()) mp4.SpeedUp(factor);
  constexpr int kMinHeaders = 2;  // of the movie and of its track
  return mp4.Good() && mp4.Headers() >= kMinHeaders;
}

void SpeedUpMp4(const std::filesystem::path& file, double factor) {
  std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
  if (!SpeedUpMp4(stream, factor)) {
    throw RunError(fmt::format("{}: is no MP4 file that can be changed", file.string()));
  }
}

}  // namespace ceilmap::recordings
