#include "app/bags/result_messages.hpp"

#include "app/bags/cdr.hpp"
#include "app/bags/message_fields.hpp"

namespace ceilmap::bags {
namespace {

constexpr std::size_t kTextBytes = 4;  // at least, of a text in a message

DiagnosticsMessage::Status ReadStatus(CdrReader& reader) {
  DiagnosticsMessage::Status status;
  status.level = static_cast<DiagnosticsMessage::Level>(reader.Number<std::uint8_t>());
  status.name = reader.Text();
  status.message = reader.Text();
  status.hardware_id = reader.Text();
  status.values.resize(reader.Length(2 * kTextBytes));
  for (auto& [key, value] : status.values) {
    key = reader.Text();
    value = reader.Text();
  }
  return status;
}

}  // namespace

PoseMessage DecodePose(std::span<const std::uint8_t> data, MessageEncoding encoding) {
  CdrReader reader(data, encoding);
  PoseMessage message;
  message.header = ReadHeader(reader);
  message.pose = ReadTransform(reader);
  reader.Numbers(message.covariance);
  return message;
}

DiagnosticsMessage DecodeDiagnostics(std::span<const std::uint8_t> data, MessageEncoding encoding) {
  CdrReader reader(data, encoding);
  DiagnosticsMessage message;
  message.header = ReadHeader(reader);
  const std::size_t count = reader.Length(1 + 4 * kTextBytes);
  for (std::size_t i = 0; i < count; ++i) message.status.push_back(ReadStatus(reader));
  return message;
}

}  // namespace ceilmap::bags
