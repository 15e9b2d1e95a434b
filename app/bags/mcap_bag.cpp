#include "app/bags/mcap_bag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>

#include "app/bags/record_cursor.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace ceilmap::bags {
namespace {

constexpr std::int32_t kUnknownTopic = -1;

struct McapRecordHead {
  mcap::Opcode opcode = {};
  std::uint64_t length = 0;  // of the content
};

McapRecordHead ParseMcapHead(std::span<const std::uint8_t> bytes) {
  RecordCursor cursor(bytes);
  McapRecordHead head;
  head.opcode = static_cast<mcap::Opcode>(cursor.Number<std::uint8_t>());
  head.length = cursor.Number<std::uint64_t>();
  return head;
}

std::int64_t SignedTime(std::uint64_t time_ns) {
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  return static_cast<std::int64_t>(std::min(time_ns, kMax));
}

MessageEncoding EncodingNamed(std::string_view name) {
  if (name == "cdr") return MessageEncoding::kCdr;
  return name == "ros1" ? MessageEncoding::kRos1 : MessageEncoding::kOther;
}

}  // namespace

McapBag::McapBag(const std::filesystem::path& path, std::string name)
    : ChunkedBag(path, std::move(name)) {
  std::array<std::uint8_t, mcap::kMagic.size()> magic{};
  if (file_.Size() >= magic.size()) file_.Read(0, magic);
  if (magic != mcap::kMagic) throw InputError(fmt::format("{}: is no MCAP file", file_.Name()));
  facts_.format = "MCAP";
  std::string problem;
  bool indexed = false;
  try {
    indexed = ReadSummary();
  } catch (const DamagedBytes& damage) {
    problem = damage.what();
  }
  if (!indexed) Scan(problem);
  Start();
}

bool McapBag::ReadSummary() {
  constexpr std::size_t kEndBytes =
      mcap::kRecordHeadBytes + mcap::kFooterContentBytes + mcap::kMagic.size();
  constexpr std::uint64_t kMaxSummaryBytes = std::uint64_t{256} << 20U;
  if (file_.Size() < mcap::kMagic.size() + kEndBytes) return false;
  const std::uint64_t footer_at = file_.Size() - kEndBytes;
  std::array<std::uint8_t, kEndBytes> end{};
  file_.Read(footer_at, end);
  if (!std::equal(mcap::kMagic.begin(), mcap::kMagic.end(), end.end() - mcap::kMagic.size())) {
    return false;  // cut off, which Scan reports
  }
  const McapRecordHead head = ParseMcapHead(end);
  if (head.opcode != mcap::Opcode::kFooter || head.length != mcap::kFooterContentBytes) {
    throw DamagedBytes("its footer is damaged");
  }
  const mcap::Footer footer =
      mcap::ParseFooter(std::span(end).subspan(mcap::kRecordHeadBytes, mcap::kFooterContentBytes));
  if (footer.summary_start == 0) return false;
  if (footer.summary_start < mcap::kMagic.size() || footer.summary_start > footer_at ||
      footer_at - footer.summary_start > kMaxSummaryBytes) {
    throw DamagedBytes("its footer names no place of an index");
  }
  const std::size_t checked = footer_at + mcap::kRecordHeadBytes + mcap::kFooterContentBytes -
                              mcap::kFooterChecksumBytes - footer.summary_start;
  Buffer summary;
  summary.Resize(checked);
  file_.Read(footer.summary_start, summary.Bytes());
  if (footer.summary_crc != 0 && mcap::Checksum(summary.Bytes()) != footer.summary_crc) {
    throw DamagedBytes("its index has another checksum than stated");
  }
  ReadSummaryRecords(
      summary.Bytes().first(static_cast<std::size_t>(footer_at - footer.summary_start)),
      footer.summary_start);
  return !places_.empty();
}

void McapBag::ReadSummaryRecords(std::span<const std::uint8_t> summary, std::uint64_t start) {
  std::vector<mcap::ChunkIndex> chunks;
  std::vector<mcap::Channel> channels;  // may stand before their schemas
  std::optional<mcap::Statistics> statistics;
  for (RecordCursor records(summary); !records.Done();) {
    const McapRecordHead head = ParseMcapHead(records.Bytes(mcap::kRecordHeadBytes));
    const std::span<const std::uint8_t> content = records.Bytes(head.length);
    if (head.opcode == mcap::Opcode::kSchema) DefineSchema(mcap::ParseSchema(content));
    if (head.opcode == mcap::Opcode::kChannel) channels.push_back(mcap::ParseChannel(content));
    if (head.opcode == mcap::Opcode::kChunkIndex) chunks.push_back(mcap::ParseChunkIndex(content));
    if (head.opcode == mcap::Opcode::kStatistics) statistics = mcap::ParseStatistics(content);
  }
  for (const mcap::Channel& channel : channels) DefineChannel(channel);
  for (const mcap::ChunkIndex& chunk : chunks) AddIndexed(chunk, start);
  if (!Disjoint()) throw DamagedBytes("its index names a chunk twice");
  if (statistics) AddStatistics(*statistics);
}

void McapBag::AddIndexed(const mcap::ChunkIndex& index, std::uint64_t data_end) {
  if (index.offset < mcap::kMagic.size() || index.offset > data_end ||
      index.length > data_end - index.offset || index.length < mcap::kRecordHeadBytes) {
    throw DamagedBytes("its index names a chunk outside of the data");
  }
  ChunkPlace place;
  place.offset = index.offset;
  place.length = index.length;
  place.first_ns = SignedTime(index.first_time);
  place.last_ns = SignedTime(index.last_time);
  for (const auto& [channel, ignored] : index.index) {
    place.topics.push_back(IndexedTopic(channel));
  }
  AddCompression(index.compression);
  if (index.last_time != 0) AddTime(place.first_ns, place.last_ns);  // of an empty chunk: 0
  places_.push_back(std::move(place));
}

std::uint32_t McapBag::IndexedTopic(std::uint16_t channel) const {
  const std::int32_t topic = channel < channels_.size() ? channels_[channel] : kUnknownTopic;
  if (topic == kUnknownTopic) {
    throw DamagedBytes(fmt::format("its index does not define channel {}", channel));
  }
  return static_cast<std::uint32_t>(topic);
}

void McapBag::AddStatistics(const mcap::Statistics& statistics) {
  for (const std::int32_t topic : channels_) {
    if (topic != kUnknownTopic) topics_.Count(static_cast<std::uint32_t>(topic), 0);
  }
  for (const auto& [channel, count] : statistics.channels) {
    topics_.Count(IndexedTopic(channel), SignedTime(count));
  }
}

void McapBag::Scan(const std::string& index_problem) {
  // What the index gave before it turned out to be damaged.
  topics_ = {};
  places_.clear();
  schemas_.clear();
  channels_.clear();
  facts_ = {.format = facts_.format, .compression = {}, .first_ns = {}, .last_ns = {}};

  scanning_ = true;
  bool complete = true;
  const std::uint64_t end = ScanRecords(mcap::kMagic.size(), complete);
  scanning_ = false;
  if (!complete) {
    Warn(fmt::format("is cut off or damaged at byte {} of {}; the {} messages before are used",
                     end,
                     file_.Size(),
                     scanned_messages_));
  } else if (!index_problem.empty()) {
    Warn(index_problem + "; the whole file was read instead");
  }
}

std::uint64_t McapBag::ScanRecords(std::uint64_t at, bool& complete) {
  constexpr std::uint64_t kMaxDefinitionBytes = std::uint64_t{64} << 10U;
  FileWindow window(file_);
  complete = false;
  while (true) {
    const std::span<const std::uint8_t> bytes = window.View(at, mcap::kRecordHeadBytes);
    if (bytes.size() < mcap::kRecordHeadBytes) return at;
    const McapRecordHead head = ParseMcapHead(bytes);
    complete = head.opcode == mcap::Opcode::kDataEnd || head.opcode == mcap::Opcode::kFooter;
    if (complete || head.opcode == mcap::Opcode{}) return at;
    const std::uint64_t content = at + mcap::kRecordHeadBytes;
    const bool cut = head.length > file_.Size() - content;
    if (head.opcode == mcap::Opcode::kChunk) {
      ScanChunk(at, cut ? file_.Size() - at : mcap::kRecordHeadBytes + head.length, cut);
    }
    if (cut) return at;
    try {
      if (head.opcode == mcap::Opcode::kMessage) {
        const auto shown =
            window.View(content, std::min<std::size_t>(head.length, mcap::kMessageHeadBytes));
        ScanMessage(at, mcap::kRecordHeadBytes + head.length, mcap::ParseMessageHead(shown));
      } else {
        EndLoose();
        const std::uint64_t shown = std::min(head.length, kMaxDefinitionBytes);
        if (head.opcode == mcap::Opcode::kSchema || head.opcode == mcap::Opcode::kChannel) {
          ScanContent(head.opcode, window.View(content, static_cast<std::size_t>(shown)));
        }
      }
    } catch (const DamagedBytes&) {
      return at;
    }
    at = content + head.length;
  }
}

void McapBag::ScanContent(mcap::Opcode opcode, std::span<const std::uint8_t> content) {
  if (opcode == mcap::Opcode::kSchema) DefineSchema(mcap::ParseSchema(content));
  if (opcode == mcap::Opcode::kChannel) DefineChannel(mcap::ParseChannel(content));
}

void McapBag::ScanMessage(std::uint64_t at, std::uint64_t length, const mcap::MessageHead& head) {
  if (!ScanLoose(at, length)) return;
  const std::int32_t topic = TopicOf(head.channel_id);
  if (topic == kUnknownTopic) return;
  AddLoose(SignedTime(head.log_time), static_cast<std::uint32_t>(topic));
}

void McapBag::LoadChunk(const ChunkPlace& place, ChunkContent& content) {
  std::array<std::uint8_t, 256> start{};  // a head has about 60 bytes
  const std::span<std::uint8_t> shown = std::span(start).first(
      static_cast<std::size_t>(std::min<std::uint64_t>(start.size(), place.length)));
  file_.Read(place.offset, shown);
  const McapRecordHead record = ParseMcapHead(shown);
  const std::uint64_t length = place.length - mcap::kRecordHeadBytes;
  if (record.opcode != mcap::Opcode::kChunk) throw DamagedBytes("is no chunk");
  if (!place.cut && record.length != length) {
    throw DamagedBytes("has another length than the index states");
  }
  std::size_t head_bytes = 0;
  const mcap::ChunkHead head =
      mcap::ParseChunkHead(shown.subspan(mcap::kRecordHeadBytes), head_bytes);
  const std::optional<Compression> compression = CompressionNamed(head.compression);
  if (!compression) {
    throw DamagedBytes(
        fmt::format("is compressed by '{}', must be zstd, lz4 or none", Shown(head.compression)));
  }
  if (scanning_) AddCompression(head.compression);
  const std::uint64_t there = length - head_bytes;
  if (!place.cut && head.records_size > there)
    throw DamagedBytes("has another length than its content");
  const std::uint64_t stored = std::min(head.records_size, there);
  const bool whole = ReadPacked(place.offset + mcap::kRecordHeadBytes + head_bytes,
                                stored,
                                *compression,
                                head.uncompressed_size,
                                content.bytes);
  if (whole && head.uncompressed_crc != 0 &&
      mcap::Checksum(content.bytes.Bytes()) != head.uncompressed_crc) {
    throw DamagedBytes("has another checksum than stated");
  }
  if (!whole && !place.cut) {
    Warn(fmt::format("the chunk at byte {} is damaged; what comes before the damage is used",
                     place.offset));
  }
  ListMessages(content, place, whole);
}

// Of a chunk that is not complete the last record is cut, which was reported.
void McapBag::ListMessages(ChunkContent& content, const ChunkPlace& place, bool complete) {
  const std::span<const std::uint8_t> bytes = content.bytes.Bytes();
  std::size_t at = 0;
  while (bytes.size() - at >= mcap::kRecordHeadBytes) {
    const McapRecordHead head = ParseMcapHead(bytes.subspan(at, mcap::kRecordHeadBytes));
    at += mcap::kRecordHeadBytes;
    if (head.opcode == mcap::Opcode{} || head.length > bytes.size() - at) {
      at = bytes.size() + 1;
      break;
    }
    const auto record = bytes.subspan(at, static_cast<std::size_t>(head.length));
    if (head.opcode == mcap::Opcode::kMessage) {
      const mcap::MessageHead message = mcap::ParseMessageHead(record);
      const std::int32_t topic = TopicOf(message.channel_id);
      if (topic != kUnknownTopic && Wanted(static_cast<std::uint32_t>(topic))) {
        content.messages.push_back(
            {SignedTime(message.log_time),
             static_cast<std::uint32_t>(topic),
             static_cast<std::uint32_t>(record.size() - mcap::kMessageHeadBytes),
             at + mcap::kMessageHeadBytes});
      }
    } else if (scanning_) {
      ScanContent(head.opcode, record);
    }
    at += record.size();
  }
  if (at != bytes.size() && complete) {
    Warn(fmt::format("the chunk at byte {} has a damaged record; the messages before it are used",
                     place.offset));
  }
}

std::int32_t McapBag::TopicOf(std::uint16_t channel) {
  const std::int32_t topic = channel < channels_.size() ? channels_[channel] : kUnknownTopic;
  if (topic == kUnknownTopic) {
    Warn(fmt::format("messages of channel {}, which is not defined, are skipped", channel));
  }
  return topic;
}

void McapBag::DefineSchema(const mcap::Schema& schema) {
  const std::pair<std::string, std::string> named(schema.name, schema.encoding);
  const auto [known, added] = schemas_.try_emplace(schema.id, named);
  if (!added && known->second != named) {
    Warn(fmt::format("schema {} is defined twice, as '{}' and as '{}'; the first is used",
                     schema.id,
                     Shown(known->second.first),
                     Shown(named.first)));
  }
}

void McapBag::DefineChannel(const mcap::Channel& channel) {
  const MessageEncoding encoding = EncodingNamed(channel.message_encoding);
  std::string type;
  const auto schema = schemas_.find(channel.schema_id);
  if (schema != schemas_.end() && channel.schema_id != 0) {
    type = encoding == MessageEncoding::kRos1 ? Ros2TypeName(schema->second.first)
                                              : schema->second.first;
  } else {
    Warn(fmt::format("topic '{}' has no schema, so that its type is not known",
                     Shown(channel.topic)));
  }
  if (channel.id >= channels_.size()) channels_.resize(channel.id + std::size_t{1}, kUnknownTopic);
  std::int32_t& known = channels_[channel.id];
  if (known == kUnknownTopic) {
    known = static_cast<std::int32_t>(topics_.Add(std::string(channel.topic), type, encoding));
    return;
  }
  const Topic& first = topics_.At(static_cast<std::uint32_t>(known));
  if (first.name != channel.topic || first.type != type || first.encoding != encoding) {
    Warn(
        fmt::format("channel {} is defined twice, as '{}' ({}) and as '{}' ({}); the first is used",
                    channel.id,
                    Shown(first.name),
                    Shown(first.type),
                    Shown(channel.topic),
                    Shown(type)));
  }
}

}  // namespace ceilmap::bags
