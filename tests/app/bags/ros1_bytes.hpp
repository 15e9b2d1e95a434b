#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "tests/app/bags/bag_bytes.hpp"

/// ROS 1 bags composed record by record.
namespace ceilmap::bags::bytes {

inline const std::string kRos1Magic = "#ROSBAG V2.0\n";

inline std::string Field(std::string_view name, const std::string& value) {
  return Text(std::string(name) + "=" + value);
}
inline std::string Ros1Record(const std::string& header, const std::string& data) {
  return Text(header) + Text(data);
}
inline std::string Ros1Time(std::uint64_t ns) {
  constexpr std::uint64_t kNsPerS = 1'000'000'000;
  return U32(static_cast<std::uint32_t>(ns / kNsPerS)) +
         U32(static_cast<std::uint32_t>(ns % kNsPerS));
}
inline std::string Ros1BagHeader(std::uint64_t index_at,
                                 std::uint32_t connections,
                                 std::uint32_t chunks) {
  return Ros1Record(Field("op", U8(3)) + Field("index_pos", U64(index_at)) +
                        Field("conn_count", U32(connections)) + Field("chunk_count", U32(chunks)),
                    std::string(100, ' '));
}
inline std::string Ros1Connection(std::uint32_t number,
                                  std::string_view topic,
                                  std::string_view type) {
  return Ros1Record(
      Field("op", U8(7)) + Field("conn", U32(number)) + Field("topic", std::string(topic)),
      Field("topic", std::string(topic)) + Field("type", std::string(type)) +
          Field("md5sum", "060021388200f6f0f447d0fcd9c64743"));
}
inline std::string Ros1Message(std::uint32_t connection, std::uint64_t ns, std::string_view data) {
  return Ros1Record(
      Field("op", U8(2)) + Field("conn", U32(connection)) + Field("time", Ros1Time(ns)),
      std::string(data));
}
inline std::string Ros1Chunk(std::string_view compression,
                             std::size_t size,
                             const std::string& packed) {
  return Ros1Record(Field("op", U8(5)) + Field("compression", std::string(compression)) +
                        Field("size", U32(static_cast<std::uint32_t>(size))),
                    packed);
}
inline std::string Ros1Chunk(const std::string& records) {
  return Ros1Chunk("none", records.size(), records);
}
inline std::string Ros1ChunkInfo(std::uint64_t chunk_at,
                                 std::uint64_t start_ns,
                                 std::uint64_t end_ns,
                                 const std::string& counts) {
  return Ros1Record(Field("op", U8(6)) + Field("ver", U32(1)) + Field("chunk_pos", U64(chunk_at)) +
                        Field("start_time", Ros1Time(start_ns)) +
                        Field("end_time", Ros1Time(end_ns)) +
                        Field("count", U32(static_cast<std::uint32_t>(counts.size() / 8))),
                    counts);
}

/// A bag with its index: `data` follows the header of the bag.
inline std::string Ros1File(const std::string& data,
                            const std::string& index,
                            std::uint32_t connections,
                            std::uint32_t chunks) {
  const std::size_t index_at = kRos1Magic.size() + Ros1BagHeader(0, 0, 0).size() + data.size();
  return kRos1Magic + Ros1BagHeader(index_at, connections, chunks) + data + index;
}
/// A bag that was not closed.
inline std::string Ros1ActiveFile(const std::string& data) {
  return kRos1Magic + Ros1BagHeader(0, 0, 0) + data;
}
inline std::size_t Ros1DataAt() {
  return kRos1Magic.size() + Ros1BagHeader(0, 0, 0).size();
}

}  // namespace ceilmap::bags::bytes
