#include "tests/support/h264.hpp"

#include <cstdint>
#include <stdexcept>
#include <string_view>

namespace ceilmap::support {
namespace {

constexpr std::string_view kStartCode("\0\0\1", 3);

std::size_t BigEndian(const std::string& bytes, std::size_t at, std::size_t count) {
  std::size_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value = value << 8U | static_cast<unsigned char>(bytes.at(at + i));
  }
  return value;
}

int TypeAt(const std::string& bytes, std::size_t at) {
  constexpr unsigned kTypeBits = 0x1F;
  return static_cast<int>(static_cast<unsigned char>(bytes.at(at)) & kTypeBits);
}

struct Range {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// What the first box of the type holds among the consecutive boxes of the range.
Range FindBox(const std::string& mp4, Range in, std::string_view type) {
  constexpr std::size_t kHeader = 8;
  for (std::size_t at = in.begin; at + kHeader <= in.end;) {
    const std::size_t size = BigEndian(mp4, at, 4);
    if (size < kHeader || at + size > in.end) break;
    if (mp4.compare(at + 4, 4, type) == 0) return {at + kHeader, at + size};
    at += size;
  }
  throw std::runtime_error("the MP4 file has no box " + std::string(type));
}

}  // namespace

std::vector<NalUnit> NalUnitsOfMp4(const std::string& mp4) {
  const Range media = FindBox(mp4, {0, mp4.size()}, "mdat");
  std::vector<NalUnit> units;
  for (std::size_t at = media.begin; at + 4 < media.end;) {
    const std::size_t size = BigEndian(mp4, at, 4);
    at += 4;
    if (size == 0 || at + size > media.end) throw std::runtime_error("mdat is not H.264 alone");
    units.push_back({at, size, TypeAt(mp4, at)});
    at += size;
  }
  return units;
}

std::vector<NalUnit> NalUnitsOfAnnexB(const std::string& stream) {
  std::vector<NalUnit> units;
  std::size_t at = stream.find(kStartCode);
  while (at != std::string::npos) {
    const std::size_t begin = at + kStartCode.size();
    at = stream.find(kStartCode, begin);
    const std::size_t end = at == std::string::npos ? stream.size() : at;
    units.push_back({begin, end - begin, TypeAt(stream, begin)});
  }
  return units;
}

std::string AnnexBOf(const std::string& mp4) {
  std::string stream;
  const auto append = [&](std::size_t begin, std::size_t size) {
    stream += kStartCode;
    stream.append(mp4, begin, size);
  };
  // avcC: version, profile, compatibility, level, length size, then counted sets with lengths. It
  // lies deep in `moov`, and its name stands nowhere else.
  std::size_t at = mp4.find("avcC");
  if (at == std::string::npos) throw std::runtime_error("the MP4 file has no box avcC");
  at += 4 + 5;
  constexpr std::size_t kCountBits = 0x1F;
  for (int kind = 0; kind < 2; ++kind) {
    const std::size_t count = BigEndian(mp4, at++, 1) & kCountBits;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t size = BigEndian(mp4, at, 2);
      append(at + 2, size);
      at += 2 + size;
    }
  }
  for (const NalUnit& unit : NalUnitsOfMp4(mp4)) append(unit.begin, unit.size);
  return stream;
}

}  // namespace ceilmap::support
