#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>

#include "app/bags/chunked_bag.hpp"
#include "app/bags/ros1_records.hpp"

namespace ceilmap::bags {

/// A ROS 1 bag of version 2.0. Its chunks come from its index; where that is missing (a recording
/// that was not finished, NAME.bag.active) or damaged, the file is read once from its start, as far
/// as it goes.
class Ros1Bag : public ChunkedBag {
 public:
  /// @param name  for messages.
  /// @throws InputError when the file cannot be read or is no such bag.
  Ros1Bag(const std::filesystem::path& path, std::string name);

 private:
  /// A record's header, and where its data are.
  struct Record {
    ros1::RecordHeader header;
    std::uint64_t data_at = 0;
    std::uint32_t data_size = 0;
  };

  void LoadChunk(const ChunkPlace& place, ChunkContent& content) override;
  void ListMessages(ChunkContent& content, const ChunkPlace& place, bool complete) override;

  /// @return false when the bag has no index. @throws DamagedBytes
  bool ReadIndex();
  void AddIndexed(const ros1::RecordHeader& header, std::span<const std::uint8_t> counts);
  void EndIndexed(std::uint64_t index_at);

  void Scan(const std::string& index_problem);
  /// Reads records from `at` on. @return where the records end.
  std::uint64_t ScanRecords(std::uint64_t at);
  void ScanMessage(std::uint64_t at, const Record& record);

  /// The record at `at`; nothing where the file ends within its head. @throws DamagedBytes
  static std::optional<Record> ReadRecord(FileWindow& window, std::uint64_t at);
  void DefineConnection(const ros1::RecordHeader& header, std::span<const std::uint8_t> data);
  /// Number of the topic; nothing, with a warning, of a connection that is not defined.
  std::optional<std::uint32_t> TopicOf(const ros1::RecordHeader& message);

  std::unordered_map<std::uint32_t, std::uint32_t> connections_;  // number of the topic
};

}  // namespace ceilmap::bags
