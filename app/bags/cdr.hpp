#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "app/bags/message_error.hpp"
#include "app/bags/topic.hpp"

namespace ceilmap::bags {

/// A message of CDR begins with these bytes (OMG DDSI-RTPS 10.2): representation (2 bytes, most
/// significant first) and options. Alignment counts from behind them.
inline constexpr std::size_t kCdrHeaderBytes = 4;
inline constexpr std::uint16_t kCdrBigEndian = 0x0000;
inline constexpr std::uint16_t kCdrLittleEndian = 0x0001;

/// Reads the fields of a serialized message in order.
///
/// CDR (XCDR1): numbers are aligned to their size, texts end in a zero byte that counts, sequences
/// begin with a 32-bit length. ROS 1: the same without alignment and zero bytes, little-endian.
/// @throws MessageError when the message ends early, or a length in it is impossible.
class CdrReader {
 public:
  CdrReader(std::span<const std::uint8_t> data, MessageEncoding encoding);

  [[nodiscard]] bool Ros1() const { return ros1_; }

  template <typename T>
  T Number() {
    static_assert(std::is_arithmetic_v<T>);
    if (!ros1_) Align(sizeof(T));
    std::array<std::uint8_t, sizeof(T)> bytes{};
    std::memcpy(bytes.data(), Take(sizeof(T), "a number").data(), sizeof(T));
    return Ordered<T>(bytes);
  }
  template <std::size_t kCount>
  void Numbers(std::array<double, kCount>& numbers) {
    for (double& number : numbers) number = Number<double>();
  }
  /// Of a sequence.
  std::vector<double> Doubles();
  std::string Text();
  /// A sequence of bytes; part of the message.
  std::span<const std::uint8_t> Bytes();
  /// The length of a sequence. @param least_bytes  of each of its elements, > 0.
  std::size_t Length(std::size_t least_bytes);

 private:
  std::span<const std::uint8_t> Take(std::size_t count, const char* what);
  void Align(std::size_t size);
  template <typename T>
  T Ordered(std::array<std::uint8_t, sizeof(T)> bytes) const {
    if (swapped_) {
      for (std::size_t i = 0; i < sizeof(T) / 2; ++i) {
        std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
      }
    }
    return std::bit_cast<T>(bytes);
  }

  std::span<const std::uint8_t> data_;  // without the header
  std::size_t at_ = 0;
  bool ros1_ = false;
  bool swapped_ = false;  // the other byte order than this machine's
};

}  // namespace ceilmap::bags
