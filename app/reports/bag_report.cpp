#include "app/reports/bag_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "app/recordings/message_times.hpp"
#include "calib/base/one_line.hpp"

namespace fs = std::filesystem;

namespace ceilmap::reports {
namespace {

std::uintmax_t BytesOf(const fs::path& bag) {
  std::error_code ignored;
  if (!fs::is_directory(bag, ignored)) return fs::file_size(bag, ignored);
  std::uintmax_t bytes = 0;
  for (const fs::directory_entry& file : fs::directory_iterator(bag, ignored)) {
    if (file.is_regular_file(ignored)) bytes += file.file_size(ignored);
  }
  return bytes;
}

// Where the file has no index.
void CountMessages(bags::BagReader& reader, BagContent& content) {
  bags::RawMessage message;
  std::optional<std::int64_t> first_ns;
  std::optional<std::int64_t> last_ns;
  while (reader.Next(message)) {
    ++content.topics[message.topic].messages;
    first_ns = std::min(first_ns.value_or(message.log_time_ns), message.log_time_ns);
    last_ns = std::max(last_ns.value_or(message.log_time_ns), message.log_time_ns);
  }
  content.facts.first_ns = first_ns;
  content.facts.last_ns = last_ns;
}

const char* ToText(bags::MessageEncoding encoding) {
  switch (encoding) {
    case bags::MessageEncoding::kCdr:
      return "cdr";
    case bags::MessageEncoding::kRos1:
      return "ros1";
    case bags::MessageEncoding::kOther:
      break;
  }
  return "other";
}

}  // namespace

BagContent InspectBag(const fs::path& bag) {
  const std::unique_ptr<bags::BagReader> reader = bags::BagReader::Open(bag);
  BagContent content;
  content.facts = reader->Facts();
  content.file_bytes = BytesOf(bag);
  bool counted = true;
  for (const bags::Topic& topic : reader->Topics()) {
    content.topics.push_back({topic, topic.messages.value_or(0), {}});
    counted = counted && topic.messages;
  }
  if (!counted) {
    for (BagContent::Topic& topic : content.topics) topic.messages = 0;
    CountMessages(*reader, content);
  }
  content.first_s = recordings::SecondsOf(content.facts.first_ns.value_or(0));
  content.last_s = recordings::SecondsOf(content.facts.last_ns.value_or(0));
  const double duration_s = content.last_s - content.first_s;
  for (BagContent::Topic& topic : content.topics) {
    content.messages += topic.messages;
    if (topic.messages < 2 || !(duration_s > 0)) continue;
    topic.rate_hz = static_cast<double>(topic.messages - 1) / duration_s;
  }
  content.warnings = reader->Warnings();
  return content;
}

nlohmann::ordered_json ToJson(const BagContent& content) {
  nlohmann::ordered_json topics = nlohmann::ordered_json::array();
  for (const BagContent::Topic& topic : content.topics) {
    topics.push_back(
        {{"name", topic.topic.name},
         {"type", topic.topic.type},
         {"encoding", ToText(topic.topic.encoding)},
         {"messages", topic.messages},
         {"rate_hz",
          topic.rate_hz ? nlohmann::ordered_json(*topic.rate_hz) : nlohmann::ordered_json()}});
  }
  return {{"format", content.facts.format},
          {"compression", content.facts.compression},
          {"first_stamp_s", content.first_s},
          {"last_stamp_s", content.last_s},
          {"duration_s", content.last_s - content.first_s},
          {"messages", content.messages},
          {"file_bytes", content.file_bytes},
          {"topics", topics},
          {"warnings", content.warnings}};
}

terminal::Table FactsOf(const BagContent& content) {
  terminal::Table table;
  table.AddRow({"format", content.facts.format});
  table.AddRow({"compression", content.facts.compression});
  table.AddRow({"time", fmt::format("{:.3f} .. {:.3f} s", content.first_s, content.last_s)});
  table.AddRow({"duration", fmt::format("{:.3f} s", content.last_s - content.first_s)});
  table.AddRow({"messages", fmt::format("{}", content.messages)});
  table.AddRow({"size", fmt::format("{:.2f} MB", static_cast<double>(content.file_bytes) * 1e-6)});
  return table;
}

terminal::Table TopicsOf(const BagContent& content) {
  terminal::Table table;
  table.AddRow({"topic", "type", "messages", "Hz"});
  for (const BagContent::Topic& topic : content.topics) {
    table.AddRow({InOneLine(topic.topic.name),
                  InOneLine(topic.topic.type),
                  fmt::format("{}", topic.messages),
                  topic.rate_hz ? fmt::format("{:.2f}", *topic.rate_hz) : "-"});
  }
  return table;
}

}  // namespace ceilmap::reports
