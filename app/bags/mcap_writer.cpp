#include "app/bags/mcap_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "app/bags/byte_writer.hpp"
#include "app/bags/compression.hpp"
#include "app/bags/mcap_records.hpp"
#include "app/bags/message_types.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::bags {
namespace {

using Bytes = std::vector<std::uint8_t>;
using mcap::Opcode;

template <typename Number>
void Put(Number number, Bytes& out) {
  AppendLittleEndian(number, out);
}

void PutText(std::string_view text, Bytes& out) {
  Put(static_cast<std::uint32_t>(text.size()), out);
  out.insert(out.end(), text.begin(), text.end());
}

// Arrays and maps begin with their length in bytes.
void PutSized(const Bytes& content, Bytes& out) {
  Put(static_cast<std::uint32_t>(content.size()), out);
  AppendBytes(content, out);
}

void PutTexts(const std::map<std::string, std::string>& texts, Bytes& out) {
  Bytes content;
  for (const auto& [key, value] : texts) {
    PutText(key, content);
    PutText(value, content);
  }
  PutSized(content, out);
}

void PutRecordStart(Opcode opcode, std::uint64_t length, Bytes& out) {
  Put(static_cast<std::uint8_t>(opcode), out);
  Put(length, out);
}

void PutRecord(Opcode opcode, const Bytes& content, Bytes& out) {
  PutRecordStart(opcode, content.size(), out);
  AppendBytes(content, out);
}

// As YAML, with the numbers of rmw's enumerations: this is what ROS 2 Humble writes, and what later
// releases still read.
std::string QosProfile(Durability durability) {
  constexpr std::string_view kInfinite = "    sec: 9223372036\n    nsec: 854775807\n";
  return fmt::format(
      "- history: 1\n"
      "  depth: {}\n"
      "  reliability: 1\n"
      "  durability: {}\n"
      "  deadline:\n{}"
      "  lifespan:\n{}"
      "  liveliness: 1\n"
      "  liveliness_lease_duration:\n{}"
      "  avoid_ros_namespace_conventions: false",
      durability == Durability::kTransientLocal ? 1 : 10,
      durability == Durability::kTransientLocal ? 1 : 2,
      kInfinite,
      kInfinite,
      kInfinite);
}

}  // namespace

McapChannel RosChannel(std::string topic, std::string_view type, Durability durability) {
  McapChannel channel;
  channel.topic = std::move(topic);
  channel.schema_name = type;
  channel.schema = MessageDefinition(type);
  channel.metadata["offered_qos_profiles"] = QosProfile(durability);
  return channel;
}

void McapWriter::Range::Add(std::uint64_t time) {
  first = empty ? time : std::min(first, time);
  last = empty ? time : std::max(last, time);
  empty = false;
}

McapWriter::McapWriter(const std::filesystem::path& file, const McapOptions& options)
    : options_(options), file_(file), stream_(file_.PartialPath(), std::ios::binary) {
  Bytes header;
  PutText("ros2", header);
  PutText("ceilmap " CEILMAP_VERSION, header);
  Bytes start(mcap::kMagic.begin(), mcap::kMagic.end());
  PutRecord(Opcode::kHeader, header, start);
  Append(start);
  WriteMetadata();
}

// With this record rosbag2 of all releases takes the profiles of the channels for those of Humble.
void McapWriter::WriteMetadata() {
  constexpr std::string_view kName = "rosbag2";
  Bytes content;
  PutText(kName, content);
  PutTexts({{"ROS_DISTRO", "humble"}}, content);
  Bytes record;
  PutRecord(Opcode::kMetadata, content, record);

  Bytes index;
  Put(position_, index);
  Put(static_cast<std::uint64_t>(record.size()), index);
  PutText(kName, index);
  PutRecord(Opcode::kMetadataIndex, index, metadata_indexes_);
  Append(record);
}

void McapWriter::RequireWritten() const {
  if (stream_) return;
  throw RunError(fmt::format("{}: cannot be written; is the disk full?", file_.Target().string()));
}

void McapWriter::Append(std::span<const std::uint8_t> bytes) {
  stream_.write(reinterpret_cast<const char*>(bytes.data()),
                static_cast<std::streamsize>(bytes.size()));
  RequireWritten();
  position_ += bytes.size();
  crc_ = mcap::Checksum(bytes, crc_);
}

std::uint16_t McapWriter::AddSchema(const McapChannel& channel) {
  if (channel.schema_name.empty()) return 0;
  const auto [at, is_new] = schema_ids_.try_emplace(
      channel.schema_name, static_cast<std::uint16_t>(schema_ids_.size() + 1));
  if (!is_new) return at->second;
  Bytes content;
  Put(at->second, content);
  PutText(channel.schema_name, content);
  PutText(channel.schema_encoding, content);
  PutText(channel.schema, content);
  PutRecord(Opcode::kSchema, content, chunk_);
  PutRecord(Opcode::kSchema, content, schema_records_);
  return at->second;
}

McapWriter::ChannelId McapWriter::Add(const McapChannel& channel) {
  if (channels_.size() == std::numeric_limits<ChannelId>::max()) {
    throw RunError(fmt::format("{}: too many topics", file_.Target().string()));
  }
  const std::uint16_t schema = AddSchema(channel);
  channels_.emplace_back();
  const auto id = static_cast<ChannelId>(channels_.size());
  Bytes content;
  Put(id, content);
  Put(schema, content);
  PutText(channel.topic, content);
  PutText(channel.message_encoding, content);
  PutTexts(channel.metadata, content);
  PutRecord(Opcode::kChannel, content, chunk_);
  PutRecord(Opcode::kChannel, content, channel_records_);
  return id;
}

McapWriter::ChannelId McapWriter::Add(std::string topic,
                                      std::string_view type,
                                      Durability durability) {
  return Add(RosChannel(std::move(topic), type, durability));
}

void McapWriter::Write(ChannelId channel,
                       std::int64_t log_time_ns,
                       std::span<const std::uint8_t> message) {
  if (log_time_ns < 0) {
    throw InputError(fmt::format("{}: a time is negative ({:.6f} s), which a bag cannot hold",
                                 file_.Target().string(),
                                 1e-9 * static_cast<double>(log_time_ns)));
  }
  const std::uint64_t length = mcap::kMessageHeadBytes + message.size();
  if (!chunk_times_.empty &&
      chunk_.size() + mcap::kRecordHeadBytes + length > options_.chunk_bytes) {
    CloseChunk();
  }
  ChannelState& state = channels_.at(channel - std::size_t{1});
  const auto time = static_cast<std::uint64_t>(log_time_ns);
  state.index.emplace_back(time, chunk_.size());
  PutRecordStart(Opcode::kMessage, length, chunk_);
  Put(channel, chunk_);
  Put(static_cast<std::uint32_t>(state.messages), chunk_);
  Put(time, chunk_);
  Put(time, chunk_);  // published
  AppendBytes(message, chunk_);
  ++state.messages;
  ++messages_;
  chunk_times_.Add(time);
  times_.Add(time);
}

void McapWriter::CloseChunk() {
  if (chunk_.empty()) return;
  const bool plain = options_.compression == Compression::kNone;
  const Bytes compressed = plain ? Bytes() : Compress(chunk_, options_.compression);
  const std::span<const std::uint8_t> records = plain ? chunk_ : compressed;
  const std::string_view compression = plain ? "" : NameOf(options_.compression);
  Bytes start;
  Put(chunk_times_.first, start);
  Put(chunk_times_.last, start);
  Put(static_cast<std::uint64_t>(chunk_.size()), start);
  Put(mcap::Checksum(chunk_), start);
  PutText(compression, start);
  Put(static_cast<std::uint64_t>(records.size()), start);

  const std::uint64_t chunk_start = position_;
  Bytes record;
  PutRecordStart(Opcode::kChunk, start.size() + records.size(), record);
  AppendBytes(start, record);
  Append(record);
  Append(records);
  const std::uint64_t index_start = position_;
  Bytes index_offsets;
  for (const auto& [id, offset] : WriteMessageIndexes()) {
    Put(id, index_offsets);
    Put(offset, index_offsets);
  }

  Bytes index;
  Put(chunk_times_.first, index);
  Put(chunk_times_.last, index);
  Put(chunk_start, index);
  Put(index_start - chunk_start, index);
  PutSized(index_offsets, index);
  Put(position_ - index_start, index);
  PutText(compression, index);
  Put(static_cast<std::uint64_t>(records.size()), index);
  Put(static_cast<std::uint64_t>(chunk_.size()), index);
  PutRecord(Opcode::kChunkIndex, index, chunk_indexes_);
  ++chunks_;
  chunk_.clear();
  chunk_times_ = {};
}

std::map<McapWriter::ChannelId, std::uint64_t> McapWriter::WriteMessageIndexes() {
  std::map<ChannelId, std::uint64_t> offsets;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    auto& index = channels_[i].index;
    if (index.empty()) continue;
    const auto id = static_cast<ChannelId>(i + 1);
    Bytes entries;
    for (const auto& [time, offset] : index) {
      Put(time, entries);
      Put(offset, entries);
    }
    Bytes content;
    Put(id, content);
    PutSized(entries, content);
    offsets[id] = position_;
    Bytes record;
    PutRecord(Opcode::kMessageIndex, content, record);
    Append(record);
    index.clear();
  }
  return offsets;
}

McapWriter::Bytes McapWriter::Statistics() const {
  Bytes content;
  Put(messages_, content);
  Put(static_cast<std::uint16_t>(schema_ids_.size()), content);
  Put(static_cast<std::uint32_t>(channels_.size()), content);
  Put(std::uint32_t{0}, content);  // attachments
  Put(std::uint32_t{1}, content);  // metadata
  Put(chunks_, content);
  Put(times_.first, content);
  Put(times_.last, content);
  Bytes counts;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    Put(static_cast<ChannelId>(i + 1), counts);
    Put(channels_[i].messages, counts);
  }
  PutSized(counts, content);
  Bytes record;
  PutRecord(Opcode::kStatistics, content, record);
  return record;
}

void McapWriter::WriteSummary() {
  const std::uint64_t summary_start = position_;
  const Bytes statistics = Statistics();
  Bytes offsets;
  crc_ = 0;
  using Group = std::pair<Opcode, const Bytes*>;
  for (const auto& [opcode, group] : {Group{Opcode::kSchema, &schema_records_},
                                      Group{Opcode::kChannel, &channel_records_},
                                      Group{Opcode::kStatistics, &statistics},
                                      Group{Opcode::kMetadataIndex, &metadata_indexes_},
                                      Group{Opcode::kChunkIndex, &chunk_indexes_}}) {
    if (group->empty()) continue;
    Bytes content;
    Put(static_cast<std::uint8_t>(opcode), content);
    Put(position_, content);
    Put(static_cast<std::uint64_t>(group->size()), content);
    PutRecord(Opcode::kSummaryOffset, content, offsets);
    Append(*group);
  }
  const std::uint64_t offsets_start = position_;
  Append(offsets);
  // The CRC of the summary includes the footer up to itself.
  Bytes footer;
  PutRecordStart(Opcode::kFooter, mcap::kFooterContentBytes, footer);
  Put(summary_start, footer);
  Put(offsets_start, footer);
  Append(footer);
  Bytes end;
  Put(crc_, end);
  AppendBytes(mcap::kMagic, end);
  Append(end);
}

void McapWriter::Close() {
  if (!stream_.is_open()) return;
  CloseChunk();
  Bytes content;
  Put(crc_, content);
  Bytes data_end;
  PutRecord(Opcode::kDataEnd, content, data_end);
  Append(data_end);
  WriteSummary();
  stream_.close();
  RequireWritten();
}

void McapWriter::Commit() {
  Close();
  file_.Commit();
}

}  // namespace ceilmap::bags
