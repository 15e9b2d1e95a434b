#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "app/bags/byte_file.hpp"
#include "app/bags/chunk_codec.hpp"
#include "app/bags/message_unpacker.hpp"
#include "app/bags/topic_table.hpp"
#include "app/bags/warning_list.hpp"

namespace ceilmap::bags {

/// A part of a bag that is read at once: a chunk, or a run of records outside of chunks.
struct ChunkPlace {
  std::uint64_t offset = 0;  ///< of its first record in the file
  std::uint64_t length = 0;  ///< of its records, with their heads
  bool loose = false;        ///< records outside of chunks
  bool cut = false;          ///< the file ends within it
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
  std::vector<std::uint32_t> topics;  ///< numbers by TopicTable; empty: not known
};

/// A message within the bytes of a chunk.
struct StoredMessage {
  std::int64_t log_time_ns = 0;
  std::uint32_t topic = 0;  ///< number by TopicTable
  std::uint32_t size = 0;
  std::uint64_t offset = 0;
};

/// A chunk in memory.
struct ChunkContent {
  Buffer bytes;
  std::vector<StoredMessage> messages;
};

/// A bag in one file whose messages are in chunks. Chunks are opened in the order of their first
/// messages, and the messages of all that overlap in time are merged.
class ChunkedBag : public BagReader {
 public:
  ~ChunkedBag() override;
  [[nodiscard]] const std::vector<Topic>& Topics() const override { return topics_.Sorted(); }
  [[nodiscard]] BagFacts Facts() const override { return facts_; }
  void Select(const std::vector<std::size_t>& topics) override;
  bool Next(RawMessage& message) override;
  [[nodiscard]] std::vector<std::string> Warnings() const override { return warnings_.All(); }

 protected:
  ChunkedBag(const std::filesystem::path& path, std::string name);

  /// Reads a chunk and lists its messages by ListMessages.
  /// @throws DamagedBytes when nothing of it can be used, InputError when the file cannot be read.
  virtual void LoadChunk(const ChunkPlace& place, ChunkContent& content) = 0;
  /// Lists the messages, of topics that Wanted accepts, in the bytes of a chunk, in the order of
  /// the file. Warns of damage; what comes before it remains.
  /// @param complete  false: the bytes end early, which was reported.
  virtual void ListMessages(ChunkContent& content, const ChunkPlace& place, bool complete) = 0;

  /// While a file without index is read: adds a chunk of `length` bytes with its messages.
  void ScanChunk(std::uint64_t at, std::uint64_t length, bool cut);
  /// The same of a record of a message outside of chunks. Neighbours are one place.
  /// @return false, with a warning, when it is too large; otherwise the caller calls AddLoose.
  bool ScanLoose(std::uint64_t at, std::uint64_t length);
  /// The message of the record.
  void AddLoose(std::int64_t log_time_ns, std::uint32_t topic);
  /// Another record follows: the next message outside of chunks begins a new place.
  void EndLoose() { loose_open_ = false; }

  /// Ends the constructor of a format, when all topics and places are known.
  void Start();

  /// True of all topics before Start.
  [[nodiscard]] bool Wanted(std::uint32_t topic) const {
    return wanted_.empty() || wanted_[topic] != 0;
  }
  void Warn(const std::string& text) { warnings_.Add(text); }

  /// Records what a chunk compressed by `compression` says to Facts.
  void AddCompression(std::string_view name);
  void AddTime(std::int64_t first_ns, std::int64_t last_ns);

  /// Extends the times and topics of a place by a message, and the facts of the bag.
  void AddMessage(ChunkPlace& place, std::int64_t log_time_ns, std::uint32_t topic);

  /// Reads `packed_size` bytes of the file and decompresses them to `size` bytes.
  /// @return false when they are damaged or end early; `unpacked` has what came before.
  /// @throws DamagedBytes when the sizes are impossible.
  bool ReadPacked(std::uint64_t at,
                  std::uint64_t packed_size,
                  Compression compression,
                  std::uint64_t size,
                  Buffer& unpacked);

  /// True when no two places share bytes of the file; sorts them by their offsets.
  bool Disjoint();

  ByteFile file_;
  TopicTable topics_;
  std::vector<ChunkPlace> places_;
  BagFacts facts_;
  bool scanning_ = false;  ///< a file without index is being read
  std::uint64_t scanned_messages_ = 0;

 private:
  struct OpenChunk;

  void Load(const ChunkPlace& place, ChunkContent& content);
  void Rewind();
  [[nodiscard]] bool Due(const ChunkPlace& place) const;
  void Open(std::size_t place);
  void LoadSorted(OpenChunk& chunk);
  void MakeRoom(const OpenChunk& kept, std::uint64_t bytes);
  void Close(std::unique_ptr<OpenChunk> chunk);
  void PassGiven();

  bool loose_open_ = false;  // the last of places_ may become longer
  WarningList warnings_;
  MessageUnpacker unpacker_;
  Buffer packed_;                       // of the chunk that is being loaded
  std::vector<char> wanted_;            // by topic number
  std::vector<std::uint64_t> seen_in_;  // offset of the place where a topic was last
  std::size_t next_place_ = 0;
  std::vector<std::unique_ptr<OpenChunk>> open_;  // a heap, the earliest message first
  bool given_ = false;                            // the first of open_ was returned
  std::vector<ChunkContent> spare_;               // memory for the next chunks
};

}  // namespace ceilmap::bags
