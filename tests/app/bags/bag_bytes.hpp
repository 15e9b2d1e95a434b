#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

/// Bags and messages composed byte by byte.
namespace ceilmap::bags::bytes {

template <typename T>
std::string Number(T value, bool big_endian = false) {
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (big_endian == (std::endian::native == std::endian::little)) {
    std::reverse(bytes.begin(), bytes.end());
  }
  return {bytes.data(), bytes.size()};
}
inline std::string U8(std::uint8_t value) {
  return Number(value);
}
inline std::string U16(std::uint16_t value) {
  return Number(value);
}
inline std::string U32(std::uint32_t value) {
  return Number(value);
}
inline std::string U64(std::uint64_t value) {
  return Number(value);
}
/// A text, or any bytes, after their 32-bit length.
inline std::string Text(std::string_view text) {
  return U32(static_cast<std::uint32_t>(text.size())) + std::string(text);
}

/// A message of CDR or of ROS 1, field by field.
class MessageBytes {
 public:
  enum class Form : std::uint8_t { kCdrLittle, kCdrBig, kRos1 };

  explicit MessageBytes(Form form) : form_(form) {}

  template <typename T>
  MessageBytes& Put(T value) {
    if (form_ != Form::kRos1) body_.resize((body_.size() + sizeof(T) - 1) / sizeof(T) * sizeof(T));
    body_ += Number(value, form_ == Form::kCdrBig);
    return *this;
  }
  MessageBytes& PutDoubles(const std::vector<double>& values) {
    for (const double value : values) Put(value);
    return *this;
  }
  MessageBytes& PutText(std::string_view text) {
    const bool terminated = form_ != Form::kRos1;
    Put(static_cast<std::uint32_t>(text.size() + (terminated ? 1 : 0)));
    body_ += text;
    if (terminated) body_ += '\0';
    return *this;
  }
  MessageBytes& PutBytes(std::string_view bytes) {
    Put(static_cast<std::uint32_t>(bytes.size()));
    body_ += bytes;
    return *this;
  }
  MessageBytes& PutHeader(std::int32_t seconds, std::uint32_t ns, std::string_view frame_id) {
    if (form_ == Form::kRos1) Put(std::uint32_t{7});
    return Put(seconds).Put(ns).PutText(frame_id);
  }
  [[nodiscard]] std::string Bytes() const {
    if (form_ == Form::kRos1) return body_;
    return std::string("\0", 1) + (form_ == Form::kCdrBig ? '\0' : '\1') + std::string(2, '\0') +
           body_;
  }

 private:
  Form form_;
  std::string body_;
};

}  // namespace ceilmap::bags::bytes
