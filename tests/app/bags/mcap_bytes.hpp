#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tests/app/bags/bag_bytes.hpp"

/// MCAP files composed record by record.
namespace ceilmap::bags::bytes {

inline const std::string kMcapMagic("\x89MCAP0\r\n", 8);

inline std::string McapRecord(int opcode, const std::string& content) {
  return U8(static_cast<std::uint8_t>(opcode)) + U64(content.size()) + content;
}
inline std::string McapHeader() {
  return McapRecord(0x01, Text("ros2") + Text("test"));
}
inline std::string McapSchema(std::uint16_t id,
                              std::string_view name,
                              std::string_view encoding = "ros2msg") {
  return McapRecord(0x03, U16(id) + Text(name) + Text(encoding) + Text("definition"));
}
inline std::string McapChannel(std::uint16_t id,
                               std::uint16_t schema,
                               std::string_view topic,
                               std::string_view encoding = "cdr") {
  return McapRecord(0x04, U16(id) + U16(schema) + Text(topic) + Text(encoding) + U32(0));
}
inline std::string McapMessage(std::uint16_t channel, std::uint64_t time, std::string_view data) {
  return McapRecord(0x05, U16(channel) + U32(0) + U64(time) + U64(time) + std::string(data));
}
inline std::string McapChunk(std::uint64_t first,
                             std::uint64_t last,
                             const std::string& records,
                             std::uint32_t crc = 0) {
  return McapRecord(0x06,
                    U64(first) + U64(last) + U64(records.size()) + U32(crc) + Text("") +
                        U64(records.size()) + records);
}
inline std::string McapPackedChunk(std::string_view compression,
                                   std::uint64_t size,
                                   const std::string& packed) {
  return McapRecord(
      0x06, U64(0) + U64(0) + U64(size) + U32(0) + Text(compression) + U64(packed.size()) + packed);
}
inline std::string McapDataEnd() {
  return McapRecord(0x0F, U32(0));
}
inline std::string McapChunkIndex(std::uint64_t first,
                                  std::uint64_t last,
                                  std::uint64_t offset,
                                  std::uint64_t length,
                                  const std::vector<std::uint16_t>& channels) {
  std::string index;
  for (const std::uint16_t channel : channels) index += U16(channel) + U64(0);
  return McapRecord(0x08,
                    U64(first) + U64(last) + U64(offset) + U64(length) + Text(index) + U64(0) +
                        Text("") + U64(length) + U64(length));
}
inline std::string McapStatistics(std::uint64_t first,
                                  std::uint64_t last,
                                  const std::map<std::uint16_t, std::uint64_t>& channels) {
  std::uint64_t messages = 0;
  std::string counts;
  for (const auto& [channel, count] : channels) {
    messages += count;
    counts += U16(channel) + U64(count);
  }
  return McapRecord(0x0B,
                    U64(messages) + U16(0) + U32(0) + U32(0) + U32(0) + U32(0) + U64(first) +
                        U64(last) + Text(counts));
}
inline std::string McapFooter(std::uint64_t summary_start, std::uint32_t crc = 0) {
  return McapRecord(0x02, U64(summary_start) + U64(0) + U32(crc));
}

/// A file with a summary: `data` follows the header.
inline std::string McapFile(const std::string& data, const std::string& summary) {
  const std::string start = kMcapMagic + McapHeader() + data + McapDataEnd();
  const std::uint64_t summary_start = summary.empty() ? 0 : start.size();
  return start + summary + McapFooter(summary_start) + kMcapMagic;
}

}  // namespace ceilmap::bags::bytes
