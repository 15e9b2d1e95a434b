#include "app/bags/mcap_records.hpp"

#include <libdeflate.h>

#include "app/bags/record_cursor.hpp"

namespace ceilmap::bags::mcap {
namespace {

std::map<std::uint16_t, std::uint64_t> ParseNumbers(RecordCursor& record) {
  RecordCursor entries(record.Bytes(record.Number<std::uint32_t>()));
  std::map<std::uint16_t, std::uint64_t> numbers;
  while (!entries.Done()) {
    const auto key = entries.Number<std::uint16_t>();
    numbers[key] = entries.Number<std::uint64_t>();
  }
  return numbers;
}

}  // namespace

Schema ParseSchema(std::span<const std::uint8_t> content) {
  RecordCursor record(content);
  Schema schema;
  schema.id = record.Number<std::uint16_t>();
  schema.name = record.Text();
  schema.encoding = record.Text();
  return schema;
}

Channel ParseChannel(std::span<const std::uint8_t> content) {
  RecordCursor record(content);
  Channel channel;
  channel.id = record.Number<std::uint16_t>();
  channel.schema_id = record.Number<std::uint16_t>();
  channel.topic = record.Text();
  channel.message_encoding = record.Text();
  return channel;
}

MessageHead ParseMessageHead(std::span<const std::uint8_t> content) {
  RecordCursor record(content);
  MessageHead head;
  head.channel_id = record.Number<std::uint16_t>();
  (void)record.Number<std::uint32_t>();  // sequence
  head.log_time = record.Number<std::uint64_t>();
  (void)record.Number<std::uint64_t>();  // publish time
  return head;
}

ChunkHead ParseChunkHead(std::span<const std::uint8_t> content, std::size_t& head_bytes) {
  RecordCursor record(content);
  ChunkHead head;
  head.first_time = record.Number<std::uint64_t>();
  head.last_time = record.Number<std::uint64_t>();
  head.uncompressed_size = record.Number<std::uint64_t>();
  head.uncompressed_crc = record.Number<std::uint32_t>();
  head.compression = record.Text();
  head.records_size = record.Number<std::uint64_t>();
  head_bytes = content.size() - record.Rest().size();
  return head;
}

ChunkIndex ParseChunkIndex(std::span<const std::uint8_t> content) {
  RecordCursor record(content);
  ChunkIndex index;
  index.first_time = record.Number<std::uint64_t>();
  index.last_time = record.Number<std::uint64_t>();
  index.offset = record.Number<std::uint64_t>();
  index.length = record.Number<std::uint64_t>();
  index.index = ParseNumbers(record);
  (void)record.Number<std::uint64_t>();  // length of the message indexes
  index.compression = record.Text();
  return index;
}

Statistics ParseStatistics(std::span<const std::uint8_t> content) {
  RecordCursor record(content);
  Statistics statistics;
  statistics.messages = record.Number<std::uint64_t>();
  (void)record.Number<std::uint16_t>();  // schemas
  (void)record.Number<std::uint32_t>();  // channels
  (void)record.Number<std::uint32_t>();  // attachments
  (void)record.Number<std::uint32_t>();  // metadata
  (void)record.Number<std::uint32_t>();  // chunks
  statistics.first_time = record.Number<std::uint64_t>();
  statistics.last_time = record.Number<std::uint64_t>();
  statistics.channels = ParseNumbers(record);
  return statistics;
}

Footer ParseFooter(std::span<const std::uint8_t> content) {
  RecordCursor record(content);
  Footer footer;
  footer.summary_start = record.Number<std::uint64_t>();
  (void)record.Number<std::uint64_t>();  // summary offset section
  footer.summary_crc = record.Number<std::uint32_t>();
  return footer;
}

std::uint32_t Checksum(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  return libdeflate_crc32(before, bytes.data(), bytes.size());
}

}  // namespace ceilmap::bags::mcap
