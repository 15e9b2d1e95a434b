#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

/// Records of a ROS 1 bag (http://wiki.ros.org/Bags/Format/2.0). A file is one line, kMagic, and
/// records: a header after its length (4 bytes), data after their length (4 bytes). A header is
/// fields, NAME=VALUE after their length (4 bytes). All numbers are little-endian.
namespace ceilmap::bags::ros1 {

inline constexpr std::string_view kMagic = "#ROSBAG V2.0\n";

enum class Operation : std::uint8_t {
  kNone = 0x00,
  kMessage = 0x02,
  kBagHeader = 0x03,
  kIndex = 0x04,
  kChunk = 0x05,
  kChunkInfo = 0x06,
  kConnection = 0x07,
};

/// The fields of a header, as far as it has them. Texts are parts of the record.
struct RecordHeader {
  Operation operation = Operation::kNone;
  std::optional<std::uint32_t> connection;
  std::int64_t time_ns = 0;
  std::int64_t start_ns = 0;
  std::int64_t end_ns = 0;
  std::optional<std::uint64_t> index_at;
  std::optional<std::uint64_t> chunk_at;
  std::uint32_t connections = 0;
  std::uint32_t chunks = 0;
  std::uint32_t count = 0;
  std::uint32_t size = 0;  ///< of a chunk, uncompressed
  std::string_view compression;
  std::string_view topic;
};

/// @param header  without its length. @throws DamagedBytes
RecordHeader ParseHeader(std::span<const std::uint8_t> header);
/// The type in the data of a connection, "sensor_msgs/Image"; empty: none.
std::string_view ParseType(std::span<const std::uint8_t> connection);

}  // namespace ceilmap::bags::ros1
