#include "app/bags/ros1_records.hpp"

#include "app/bags/record_cursor.hpp"

namespace ceilmap::bags::ros1 {
namespace {

struct Field {
  std::string_view name;
  std::string_view value;
};

Field NextField(RecordCursor& fields) {
  const std::string_view field = fields.Text();
  const std::size_t equals = field.find('=');
  if (equals == std::string_view::npos) throw DamagedBytes("has a field without '='");
  return {field.substr(0, equals), field.substr(equals + 1)};
}

template <typename T>
T NumberIn(std::string_view value) {
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(value.data());
  return RecordCursor({bytes, value.size()}).Number<T>();
}

// Seconds and nanoseconds of 32 bits each.
std::int64_t TimeIn(std::string_view value) {
  constexpr std::int64_t kNsPerS = 1'000'000'000;
  const auto time = NumberIn<std::uint64_t>(value);
  return static_cast<std::int64_t>(time & 0xFFFFFFFFU) * kNsPerS +
         static_cast<std::int64_t>(time >> 32U);
}

}  // namespace

RecordHeader ParseHeader(std::span<const std::uint8_t> header) {
  RecordHeader record;
  for (RecordCursor fields(header); !fields.Done();) {
    const auto [name, value] = NextField(fields);
    if (name == "op") record.operation = static_cast<Operation>(NumberIn<std::uint8_t>(value));
    if (name == "conn") record.connection = NumberIn<std::uint32_t>(value);
    if (name == "time") record.time_ns = TimeIn(value);
    if (name == "start_time") record.start_ns = TimeIn(value);
    if (name == "end_time") record.end_ns = TimeIn(value);
    if (name == "index_pos") record.index_at = NumberIn<std::uint64_t>(value);
    if (name == "chunk_pos") record.chunk_at = NumberIn<std::uint64_t>(value);
    if (name == "conn_count") record.connections = NumberIn<std::uint32_t>(value);
    if (name == "chunk_count") record.chunks = NumberIn<std::uint32_t>(value);
    if (name == "count") record.count = NumberIn<std::uint32_t>(value);
    if (name == "size") record.size = NumberIn<std::uint32_t>(value);
    if (name == "compression") record.compression = value;
    if (name == "topic") record.topic = value;
  }
  return record;
}

std::string_view ParseType(std::span<const std::uint8_t> connection) {
  std::string_view type;
  for (RecordCursor fields(connection); !fields.Done();) {
    const auto [name, value] = NextField(fields);
    if (name == "type") type = value;
  }
  return type;
}

}  // namespace ceilmap::bags::ros1
