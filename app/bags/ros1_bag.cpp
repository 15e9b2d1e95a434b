#include "app/bags/ros1_bag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "app/bags/record_cursor.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace ceilmap::bags {
namespace {

constexpr std::uint32_t kMaxHeaderBytes = std::uint32_t{1} << 20U;
constexpr std::uint32_t kMaxConnectionBytes = std::uint32_t{16} << 20U;

std::string_view AsText(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Ros1Bag::Ros1Bag(const std::filesystem::path& path, std::string name)
    : ChunkedBag(path, std::move(name)) {
  std::array<std::uint8_t, ros1::kMagic.size()> line{};
  if (file_.Size() >= line.size()) file_.Read(0, line);
  if (AsText(line) != ros1::kMagic) {
    throw InputError(fmt::format(
        "{}: is a ROS 1 bag of another version than 2.0; convert it with 'rosbag fix' of ROS 1",
        file_.Name()));
  }
  facts_.format = "ROS 1 bag";
  std::string problem;
  bool indexed = false;
  try {
    indexed = ReadIndex();
  } catch (const DamagedBytes& damage) {
    problem = damage.what();
  }
  if (!indexed) Scan(problem);
  Start();
}

std::optional<Ros1Bag::Record> Ros1Bag::ReadRecord(FileWindow& window, std::uint64_t at) {
  constexpr std::size_t kLengthBytes = 4;
  const auto first = window.View(at, kLengthBytes);
  if (first.size() < kLengthBytes) return std::nullopt;
  const auto header_size = RecordCursor(first).Number<std::uint32_t>();
  if (header_size > kMaxHeaderBytes) throw DamagedBytes("has a header that is too long");
  const std::size_t head_size = kLengthBytes + header_size + kLengthBytes;
  const auto head = window.View(at, head_size);
  if (head.size() < head_size) return std::nullopt;
  Record record;
  record.header = ros1::ParseHeader(head.subspan(kLengthBytes, header_size));
  record.data_size = RecordCursor(head.last(kLengthBytes)).Number<std::uint32_t>();
  record.data_at = at + head_size;
  return record;
}

bool Ros1Bag::ReadIndex() {
  FileWindow window(file_);
  const std::optional<Record> first = ReadRecord(window, ros1::kMagic.size());
  if (!first || first->header.operation != ros1::Operation::kBagHeader) {
    throw DamagedBytes("its first record is damaged");
  }
  const std::uint64_t index_at = first->header.index_at.value_or(0);
  const std::uint64_t records = std::uint64_t{first->header.connections} + first->header.chunks;
  if (index_at == 0) return false;
  if (index_at < ros1::kMagic.size() || index_at > file_.Size()) {
    throw DamagedBytes("its index is missing");
  }
  std::uint64_t at = index_at;
  for (std::uint64_t i = 0; i < records; ++i) {
    const std::optional<Record> record = ReadRecord(window, at);
    if (!record || record->data_size > file_.Size() - record->data_at) {
      throw DamagedBytes("its index ends early");
    }
    if (record->data_size > kMaxConnectionBytes) throw DamagedBytes("its index is damaged");
    // The texts of the header were part of the window, which moves on.
    const std::string topic(record->header.topic);
    ros1::RecordHeader header = record->header;
    const auto data = window.View(record->data_at, record->data_size);
    header.topic = topic;
    if (header.operation == ros1::Operation::kConnection) DefineConnection(header, data);
    if (header.operation == ros1::Operation::kChunkInfo) AddIndexed(header, data);
    at = record->data_at + record->data_size;
  }
  if (places_.size() != first->header.chunks || at != file_.Size()) {
    throw DamagedBytes("its index has more or fewer records than stated");
  }
  EndIndexed(index_at);
  return true;
}

void Ros1Bag::AddIndexed(const ros1::RecordHeader& header, std::span<const std::uint8_t> counts) {
  ChunkPlace place;
  place.offset = header.chunk_at.value_or(0);
  place.first_ns = header.start_ns;
  place.last_ns = header.end_ns;
  for (RecordCursor entries(counts); !entries.Done();) {
    const auto connection = entries.Number<std::uint32_t>();
    const auto count = entries.Number<std::uint32_t>();
    const auto topic = connections_.find(connection);
    if (topic == connections_.end()) {
      throw DamagedBytes(fmt::format("its index does not define connection {}", connection));
    }
    place.topics.push_back(topic->second);
    topics_.Count(topic->second, count);
  }
  if (!place.topics.empty()) AddTime(place.first_ns, place.last_ns);
  places_.push_back(std::move(place));
}

// The index has no lengths: a chunk goes at most up to the next one.
void Ros1Bag::EndIndexed(std::uint64_t index_at) {
  const bool disjoint = Disjoint();
  std::uint64_t end = index_at;
  for (auto place = places_.rbegin(); place != places_.rend(); ++place) {
    if (!disjoint || place->offset < ros1::kMagic.size() || place->offset >= end) {
      throw DamagedBytes("its index names chunks outside of the data, or twice");
    }
    place->length = end - place->offset;
    end = place->offset;
  }
  for (std::uint32_t topic = 0; topic < topics_.Size(); ++topic) topics_.Count(topic, 0);
  // Of all chunks alike, as recorders write them.
  if (places_.empty()) return;
  FileWindow window(file_);
  const std::optional<Record> chunk = ReadRecord(window, places_.front().offset);
  if (chunk) AddCompression(chunk->header.compression);
}

void Ros1Bag::Scan(const std::string& index_problem) {
  // What the index gave before it turned out to be damaged.
  topics_ = {};
  places_.clear();
  connections_.clear();
  facts_ = {.format = facts_.format, .compression = {}, .first_ns = {}, .last_ns = {}};

  scanning_ = true;
  const std::uint64_t end = ScanRecords(ros1::kMagic.size());
  scanning_ = false;
  if (end < file_.Size()) {
    Warn(fmt::format("is cut off or damaged at byte {} of {}; the {} messages before are used",
                     end,
                     file_.Size(),
                     scanned_messages_));
  } else {
    Warn((index_problem.empty() ? "has no index, as its recording was not finished"
                                : index_problem) +
         "; the whole file was read instead");
  }
}

std::uint64_t Ros1Bag::ScanRecords(std::uint64_t at) {
  FileWindow window(file_);
  while (at < file_.Size()) {
    try {
      const std::optional<Record> record = ReadRecord(window, at);
      if (!record || record->header.operation == ros1::Operation::kNone) return at;
      const bool cut = record->data_size > file_.Size() - record->data_at;
      if (record->header.operation == ros1::Operation::kChunk) {
        ScanChunk(at, cut ? file_.Size() - at : record->data_at + record->data_size - at, cut);
      }
      if (cut) return at;
      if (record->header.operation == ros1::Operation::kMessage) {
        ScanMessage(at, *record);
      } else {
        EndLoose();
      }
      if (record->header.operation == ros1::Operation::kConnection) {
        const std::string topic(record->header.topic);
        ros1::RecordHeader header = record->header;
        const auto data =
            window.View(record->data_at, std::min(record->data_size, kMaxConnectionBytes));
        header.topic = topic;
        DefineConnection(header, data);
      }
      at = record->data_at + record->data_size;
    } catch (const DamagedBytes&) {
      return at;
    }
  }
  return at;
}

void Ros1Bag::ScanMessage(std::uint64_t at, const Record& record) {
  if (!ScanLoose(at, record.data_at + record.data_size - at)) return;
  const std::optional<std::uint32_t> topic = TopicOf(record.header);
  if (topic) AddLoose(record.header.time_ns, *topic);
}

void Ros1Bag::LoadChunk(const ChunkPlace& place, ChunkContent& content) {
  constexpr std::size_t kHeadBytes = 128;
  FileWindow window(file_, kHeadBytes);
  const std::optional<Record> record = ReadRecord(window, place.offset);
  if (!record || record->header.operation != ros1::Operation::kChunk) {
    throw DamagedBytes("is no chunk");
  }
  const std::optional<Compression> compression = CompressionNamed(record->header.compression);
  if (!compression || compression == Compression::kZstd) {
    throw DamagedBytes(fmt::format("is compressed by '{}', must be bz2, lz4 or none",
                                   Shown(record->header.compression)));
  }
  if (scanning_) AddCompression(record->header.compression);
  const std::uint64_t end = place.offset + place.length;
  const std::uint64_t there = end - std::min(record->data_at, end);
  if (!place.cut && record->data_size > there) {
    throw DamagedBytes("has another length than its content");
  }
  const std::uint64_t stored = std::min<std::uint64_t>(record->data_size, there);
  const bool whole =
      ReadPacked(record->data_at, stored, *compression, record->header.size, content.bytes);
  if (!whole && !place.cut) {
    Warn(fmt::format("the chunk at byte {} is damaged; what comes before the damage is used",
                     place.offset));
  }
  ListMessages(content, place, whole);
}

void Ros1Bag::ListMessages(ChunkContent& content, const ChunkPlace& place, bool complete) {
  RecordCursor records(content.bytes.Bytes());
  try {
    while (!records.Done()) {
      const ros1::RecordHeader header =
          ros1::ParseHeader(records.Bytes(records.Number<std::uint32_t>()));
      const std::span<const std::uint8_t> data = records.Bytes(records.Number<std::uint32_t>());
      if (header.operation == ros1::Operation::kMessage) {
        const std::optional<std::uint32_t> topic = TopicOf(header);
        if (topic && Wanted(*topic)) {
          content.messages.push_back(
              {header.time_ns,
               *topic,
               static_cast<std::uint32_t>(data.size()),
               static_cast<std::uint64_t>(data.data() - content.bytes.Data())});
        }
      } else if (header.operation == ros1::Operation::kConnection && scanning_) {
        DefineConnection(header, data);
      }
    }
  } catch (const DamagedBytes&) {
    // Of a chunk that is not complete the last record is cut, which was reported.
    if (!complete) return;
    Warn(fmt::format("the chunk at byte {} has a damaged record; the messages before it are used",
                     place.offset));
  }
}

void Ros1Bag::DefineConnection(const ros1::RecordHeader& header,
                               std::span<const std::uint8_t> data) {
  if (!header.connection) throw DamagedBytes("has a connection without a number");
  const std::string type = Ros2TypeName(ros1::ParseType(data));
  const std::string name(header.topic);
  if (type.empty()) {
    Warn(fmt::format("topic '{}' has no type", Shown(name)));
  }
  const auto known = connections_.find(*header.connection);
  if (known == connections_.end()) {
    connections_[*header.connection] = topics_.Add(name, type, MessageEncoding::kRos1);
    return;
  }
  const Topic& first = topics_.At(known->second);
  if (first.name != name || first.type != type) {
    Warn(fmt::format(
        "connection {} is defined twice, as '{}' ({}) and as '{}' ({}); the first is used",
        *header.connection,
        Shown(first.name),
        Shown(first.type),
        Shown(name),
        Shown(type)));
  }
}

std::optional<std::uint32_t> Ros1Bag::TopicOf(const ros1::RecordHeader& message) {
  if (!message.connection) throw DamagedBytes("has a message without a connection");
  const auto known = connections_.find(*message.connection);
  if (known != connections_.end()) return known->second;
  Warn(fmt::format("messages of connection {}, which is not defined, are skipped",
                   *message.connection));
  return std::nullopt;
}

}  // namespace ceilmap::bags
