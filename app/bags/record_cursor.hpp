#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

namespace ceilmap::bags {

/// Bytes of a bag that cannot be what they should. The text says what is wrong and fits after "it";
/// the reader of the bag turns it into a warning with the file and the place.
class DamagedBytes : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads the little-endian fields of a record in order. @throws DamagedBytes beyond the end.
class RecordCursor {
 public:
  explicit RecordCursor(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <typename T>
  T Number() {
    static_assert(std::is_unsigned_v<T>);
    const std::span<const std::uint8_t> bytes = Bytes(sizeof(T));
    T number = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      number = static_cast<T>(number | static_cast<T>(static_cast<T>(bytes[i]) << (8 * i)));
    }
    return number;
  }
  std::span<const std::uint8_t> Bytes(std::uint64_t count) {
    if (count > bytes_.size()) throw DamagedBytes("has a field that goes beyond its record");
    const std::span<const std::uint8_t> bytes = bytes_.first(static_cast<std::size_t>(count));
    bytes_ = bytes_.subspan(static_cast<std::size_t>(count));
    return bytes;
  }
  /// Bytes after a 32-bit length. Valid as long as the record.
  std::string_view Text() {
    const std::span<const std::uint8_t> bytes = Bytes(Number<std::uint32_t>());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  [[nodiscard]] std::span<const std::uint8_t> Rest() const { return bytes_; }
  [[nodiscard]] bool Done() const { return bytes_.empty(); }

 private:
  std::span<const std::uint8_t> bytes_;
};

}  // namespace ceilmap::bags
