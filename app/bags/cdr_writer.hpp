#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "app/bags/byte_writer.hpp"

namespace ceilmap::bags {

/// Serializes the fields of a message in their order, as ROS 2 does: Common Data Representation
/// (OMG DDS-XTypes 7.4.1, version 1), little endian. Numbers are aligned to their size, counted
/// from the end of the four bytes that name the representation.
class CdrWriter {
 public:
  CdrWriter() : bytes_{0x00, 0x01, 0x00, 0x00} {}

  /// A number or a bool.
  template <typename Number>
  void Put(Number number) {
    if constexpr (std::is_same_v<Number, bool>) {
      bytes_.push_back(number ? 1 : 0);
    } else {
      Align(sizeof(Number));
      AppendLittleEndian(number, bytes_);
    }
  }
  /// An array of fixed length.
  template <typename Numbers>
  void PutAll(const Numbers& numbers) {
    for (const auto number : numbers) Put(number);
  }
  /// The length of a sequence; its elements follow.
  void PutCount(std::size_t count) { Put(static_cast<std::uint32_t>(count)); }
  /// A sequence of bytes.
  void PutBytes(std::span<const std::uint8_t> bytes) {
    PutCount(bytes.size());
    AppendBytes(bytes, bytes_);
  }
  /// A string; its length includes the zero at its end.
  void PutText(std::string_view text) {
    PutCount(text.size() + 1);
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    bytes_.push_back(0);
  }
  /// Expects that many bytes.
  void Reserve(std::size_t bytes) { bytes_.reserve(bytes); }

  [[nodiscard]] std::vector<std::uint8_t> Take() { return std::move(bytes_); }

 private:
  static constexpr std::size_t kStart = 4;

  void Align(std::size_t size) {
    while ((bytes_.size() - kStart) % size != 0) bytes_.push_back(0);
  }

  std::vector<std::uint8_t> bytes_;
};

}  // namespace ceilmap::bags
