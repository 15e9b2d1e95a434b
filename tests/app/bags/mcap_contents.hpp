#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "app/bags/mcap_records.hpp"

/// An MCAP file as a test sees it: records, chunks and checksums, without the product's reader.
namespace ceilmap::bags::test {

using Bytes = std::vector<std::uint8_t>;

// The fields of a record, in order; written from the specification, not from the writer.
class Fields {
 public:
  explicit Fields(const Bytes& bytes) : bytes_(bytes) {}

  std::uint64_t Number(int size) {
    std::uint64_t number = 0;
    for (int i = 0; i < size; ++i) number |= std::uint64_t{bytes_.at(at_ + i)} << (8 * i);
    at_ += size;
    return number;
  }
  std::string Text() {
    const Bytes bytes = Take(Number(4));
    return {bytes.begin(), bytes.end()};
  }
  Bytes Take(std::size_t size) {
    EXPECT_LE(at_ + size, bytes_.size());
    const auto from = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
    at_ += size;
    return {from, from + static_cast<std::ptrdiff_t>(size)};
  }
  [[nodiscard]] bool AtEnd() const { return at_ == bytes_.size(); }
  [[nodiscard]] std::size_t At() const { return at_; }

 private:
  const Bytes& bytes_;
  std::size_t at_ = 0;
};

struct Record {
  mcap::Opcode opcode{};
  std::size_t at = 0;  // of its opcode
  Bytes content;

  [[nodiscard]] std::size_t End() const { return at + 9 + content.size(); }
};

inline std::vector<Record> RecordsIn(const Bytes& bytes, std::size_t begin, std::size_t end) {
  std::vector<Record> records;
  Fields fields(bytes);
  fields.Take(begin);
  while (fields.At() < end) {
    Record record;
    record.at = fields.At();
    record.opcode = static_cast<mcap::Opcode>(fields.Number(1));
    record.content = fields.Take(fields.Number(8));
    records.push_back(record);
  }
  EXPECT_EQ(fields.At(), end);
  return records;
}

inline Bytes ReadBytes(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// CRC-32 bit by bit.
inline std::uint32_t CrcOf(const Bytes& bytes, std::size_t begin, std::size_t end) {
  std::uint32_t crc = ~0U;
  for (std::size_t i = begin; i < end; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

// A file, record by record.
struct McapFile {
  explicit McapFile(const std::filesystem::path& file)
      : bytes(ReadBytes(file)), records(RecordsIn(bytes, 8, bytes.size() - 8)) {}

  [[nodiscard]] std::vector<mcap::Opcode> Opcodes() const {
    std::vector<mcap::Opcode> opcodes;
    for (const Record& record : records) opcodes.push_back(record.opcode);
    return opcodes;
  }
  [[nodiscard]] std::vector<Record> Of(mcap::Opcode opcode) const {
    std::vector<Record> found;
    for (const Record& record : records) {
      if (record.opcode == opcode) found.push_back(record);
    }
    return found;
  }

  Bytes bytes;
  std::vector<Record> records;
};

struct Chunk {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::uint64_t size = 0;
  std::uint32_t crc = 0;
  std::string compression;
  Bytes data;
};

inline Chunk ChunkOf(const Record& record) {
  Fields fields(record.content);
  Chunk chunk;
  chunk.first = fields.Number(8);
  chunk.last = fields.Number(8);
  chunk.size = fields.Number(8);
  chunk.crc = static_cast<std::uint32_t>(fields.Number(4));
  chunk.compression = fields.Text();
  chunk.data = fields.Take(fields.Number(8));
  EXPECT_TRUE(fields.AtEnd());
  return chunk;
}

}  // namespace ceilmap::bags::test
