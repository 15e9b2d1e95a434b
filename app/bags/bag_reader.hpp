#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/bags/topic.hpp"

namespace ceilmap::bags {

/// One message of a bag, not decoded.
struct RawMessage {
  std::size_t topic = 0;         ///< index in BagReader::Topics()
  std::int64_t log_time_ns = 0;  ///< when it was recorded, since 1970
  /// Valid until the next call of the reader. Of MessageEncoding::kCdr it begins with the four
  /// bytes that name the byte order.
  std::span<const std::uint8_t> data;
};

/// What a bag says of itself.
struct BagFacts {
  std::string format;       ///< "MCAP", "rosbag2 (SQLite)", "rosbag2 (MCAP, 3 files)", "ROS 1 bag"
  std::string compression;  ///< "none", "zstd", "lz4", "bz2", or several: "lz4, zstd"
  std::optional<std::int64_t> first_ns;  ///< log time of the first message; unset: no message
  std::optional<std::int64_t> last_ns;
};

/// Sequential reader of a bag: MCAP, rosbag2 (SQLite or MCAP, one file or a folder with
/// metadata.yaml), ROS 1. Memory is bounded: by the largest chunk of the file, at most 512 MB, and
/// by 160 MB where smaller chunks overlap in time.
class BagReader {
 public:
  /// True for a path that Open reads: an existing file whose first bytes are those of a bag, or a
  /// folder with metadata.yaml.
  static bool IsBag(const std::filesystem::path& path);
  /// Opens a bag and reads its topics: from its index, or where that is missing or damaged by
  /// reading the file once.
  /// @throws InputError when it cannot be opened or is no bag; RunError when a file that is
  ///   compressed as a whole finds no room in the folder of temporary files.
  static std::unique_ptr<BagReader> Open(const std::filesystem::path& path);

  virtual ~BagReader() = default;

  /// Complete after Open. In order of their names.
  [[nodiscard]] virtual const std::vector<Topic>& Topics() const = 0;
  [[nodiscard]] virtual BagFacts Facts() const = 0;

  /// Next returns messages of these topics only, from the first message of the bag on. Chunks
  /// without them are not read where there is an index. Before the first call: all topics.
  virtual void Select(const std::vector<std::size_t>& topics) = 0;
  /// Reads the next message, in order of log time (of a database without an index of its times: as
  /// written); false at the end.
  /// A damaged part is skipped, with a warning; only a file that can no longer be read throws.
  /// @throws InputError when the file cannot be read.
  virtual bool Next(RawMessage& message) = 0;

  /// Problems of the file so far, one line each, which begin with the file's name.
  [[nodiscard]] virtual std::vector<std::string> Warnings() const = 0;
};

}  // namespace ceilmap::bags
