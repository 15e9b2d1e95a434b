#include "app/bags/cdr.hpp"

#include <fmt/format.h>

namespace ceilmap::bags {

CdrReader::CdrReader(std::span<const std::uint8_t> data, MessageEncoding encoding)
    : data_(data), ros1_(encoding == MessageEncoding::kRos1) {
  if (encoding == MessageEncoding::kOther) {
    throw MessageError("is serialized neither by CDR nor by ROS 1");
  }
  bool little = true;
  if (!ros1_) {
    if (data.size() < kCdrHeaderBytes) {
      throw MessageError(fmt::format("has {} bytes, less than the header of CDR", data.size()));
    }
    const int representation = data[0] << 8 | data[1];
    if (representation != kCdrBigEndian && representation != kCdrLittleEndian) {
      throw MessageError(fmt::format(
          "has the representation 0x{:04x}, must be CDR (0x0000, 0x0001)", representation));
    }
    little = representation == kCdrLittleEndian;
    data_ = data.subspan(kCdrHeaderBytes);
  }
  swapped_ = little != (std::endian::native == std::endian::little);
}

std::vector<double> CdrReader::Doubles() {
  std::vector<double> numbers(Length(sizeof(double)));
  for (double& number : numbers) number = Number<double>();
  return numbers;
}

std::string CdrReader::Text() {
  const auto length = Number<std::uint32_t>();
  const std::span<const std::uint8_t> bytes = Take(length, "a text");
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (!ros1_ && !text.empty()) {
    if (text.back() != '\0') throw MessageError("has a text without a zero byte at its end");
    text.pop_back();
  }
  return text;
}

std::span<const std::uint8_t> CdrReader::Bytes() {
  return Take(Number<std::uint32_t>(), "a sequence");
}

std::size_t CdrReader::Length(std::size_t least_bytes) {
  const auto length = Number<std::uint32_t>();
  if (length > (data_.size() - at_) / least_bytes) {
    throw MessageError(fmt::format(
        "has a sequence of {} elements, but ends {} bytes later", length, data_.size() - at_));
  }
  return length;
}

std::span<const std::uint8_t> CdrReader::Take(std::size_t count, const char* what) {
  if (count > data_.size() - at_) {
    throw MessageError(fmt::format(
        "ends early: {} of {} bytes, of which {} are there", what, count, data_.size() - at_));
  }
  at_ += count;
  return data_.subspan(at_ - count, count);
}

void CdrReader::Align(std::size_t size) {
  const std::size_t padding = (size - at_ % size) % size;
  (void)Take(padding, "a padding");
}

}  // namespace ceilmap::bags
