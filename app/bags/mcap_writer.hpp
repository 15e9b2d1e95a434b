#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/bags/chunk_codec.hpp"
#include "calib/base/atomic_file.hpp"

namespace ceilmap::bags {

struct McapOptions {
  Compression compression = Compression::kZstd;  ///< kNone, kZstd or kLz4
  /// Size of a chunk before compression. A message that is larger has a chunk of its own.
  std::size_t chunk_bytes = std::size_t{1} << 20;
};

/// A topic of the file, and the definition of its messages.
struct McapChannel {
  std::string topic;
  std::string message_encoding = "cdr";
  std::string schema_name = {};  ///< "sensor_msgs/msg/Image"; empty: without a schema
  std::string schema_encoding = "ros2msg";
  std::string schema = {};  ///< its text
  std::map<std::string, std::string> metadata = {};
};

/// What ROS 2 offers to nodes that subscribe after a message was published.
enum class Durability {
  kVolatile,
  kTransientLocal,  ///< the last message: a map, /tf_static
};

/// A channel as `ros2 bag record` writes it: the type's definition, and the quality of service as
/// metadata `offered_qos_profiles`, by which `ros2 bag play` offers the topic.
/// @param type  one of message_types.hpp.
McapChannel RosChannel(std::string topic, std::string_view type, Durability durability);

/// Writes an MCAP file of profile "ros2" (https://mcap.dev/spec): messages in chunks with their
/// CRC and message indexes, and a summary with the schemas, the channels, statistics and an index
/// of the chunks. The file is complete and in place after Commit(), or absent (AtomicFile).
class McapWriter {
 public:
  using ChannelId = std::uint16_t;

  /// @throws as AtomicFile, and RunError when the disk cannot be written; as all functions below.
  explicit McapWriter(const std::filesystem::path& file, const McapOptions& options = {});

  ChannelId Add(const McapChannel& channel);
  /// The same of a RosChannel.
  ChannelId Add(std::string topic,
                std::string_view type,
                Durability durability = Durability::kVolatile);

  /// @param log_time_ns  >= 0; in any order, but readers are faster where it increases.
  void Write(ChannelId channel, std::int64_t log_time_ns, std::span<const std::uint8_t> message);
  [[nodiscard]] std::uint64_t Messages() const { return messages_; }

  /// Completes the content, without making the file appear.
  void Close();
  void Commit();

 private:
  using Bytes = std::vector<std::uint8_t>;

  // Of times; without messages 0 and 0.
  struct Range {
    std::uint64_t first = 0;
    std::uint64_t last = 0;
    bool empty = true;

    void Add(std::uint64_t time);
  };
  struct ChannelState {
    std::uint64_t messages = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> index;  // time, offset in the open chunk
  };

  std::uint16_t AddSchema(const McapChannel& channel);
  void WriteMetadata();
  void CloseChunk();
  // Index records of the chunk that was just written. Returns the offset of that of each channel.
  std::map<ChannelId, std::uint64_t> WriteMessageIndexes();
  [[nodiscard]] Bytes Statistics() const;
  void WriteSummary();
  void Append(std::span<const std::uint8_t> bytes);
  void RequireWritten() const;

  McapOptions options_;
  AtomicFile file_;
  std::ofstream stream_;
  std::uint64_t position_ = 0;
  std::uint32_t crc_ = 0;  // of all bytes since it was set to 0

  Bytes chunk_;  // the records of the open chunk
  Range chunk_times_;
  std::vector<ChannelState> channels_;  // [id - 1]
  std::map<std::string, std::uint16_t> schema_ids_;
  std::uint64_t messages_ = 0;
  Range times_;

  // Records of the summary.
  Bytes schema_records_;
  Bytes channel_records_;
  Bytes metadata_indexes_;
  Bytes chunk_indexes_;
  std::uint32_t chunks_ = 0;
};

}  // namespace ceilmap::bags
