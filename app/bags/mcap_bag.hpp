#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/bags/chunked_bag.hpp"
#include "app/bags/mcap_records.hpp"

namespace ceilmap::bags {

/// An MCAP file. Its chunks come from its summary; where that is missing or damaged, the file is
/// read once from its start, as far as it goes.
class McapBag : public ChunkedBag {
 public:
  /// @param name  for messages.
  /// @throws InputError when the file cannot be read or is no MCAP file.
  McapBag(const std::filesystem::path& path, std::string name);

 private:
  void LoadChunk(const ChunkPlace& place, ChunkContent& content) override;
  void ListMessages(ChunkContent& content, const ChunkPlace& place, bool complete) override;

  /// @return true when the summary gives all chunks and topics. @throws DamagedBytes
  bool ReadSummary();
  void ReadSummaryRecords(std::span<const std::uint8_t> summary, std::uint64_t start);
  void AddIndexed(const mcap::ChunkIndex& index, std::uint64_t data_end);
  /// The number of the topic. @throws DamagedBytes when the channel is not defined.
  [[nodiscard]] std::uint32_t IndexedTopic(std::uint16_t channel) const;
  void AddStatistics(const mcap::Statistics& statistics);

  /// @param index_problem  why the summary is not used; empty: there is none.
  void Scan(const std::string& index_problem);
  /// Reads records from `at` on. @return where the data end.
  std::uint64_t ScanRecords(std::uint64_t at, bool& complete);
  void ScanContent(mcap::Opcode opcode, std::span<const std::uint8_t> content);
  void ScanMessage(std::uint64_t at, std::uint64_t length, const mcap::MessageHead& head);

  /// @return the number of the topic, or kUnknown with a warning.
  std::int32_t TopicOf(std::uint16_t channel);
  void DefineSchema(const mcap::Schema& schema);
  void DefineChannel(const mcap::Channel& channel);

  std::map<std::uint16_t, std::pair<std::string, std::string>> schemas_;  // name, encoding
  std::vector<std::int32_t> channels_;  // numbers of topics by channel
};

}  // namespace ceilmap::bags
