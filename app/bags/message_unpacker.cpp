#include "app/bags/message_unpacker.hpp"

#include <fmt/format.h>

#include "app/bags/chunk_codec.hpp"
#include "app/bags/record_cursor.hpp"
#include "calib/base/one_line.hpp"

namespace ceilmap::bags {

bool MessageUnpacker::Unpack(RawMessage& message, const Topic& topic, WarningList& warnings) {
  if (topic.encoding != MessageEncoding::kCdr || !IsZstd(message.data)) return true;
  try {
    DecompressMessage(message.data, unpacked_);
  } catch (const DamagedBytes& damage) {
    warnings.Add(
        fmt::format("messages of '{}' are skipped: one {}", Shown(topic.name), damage.what()));
    return false;
  }
  message.data = unpacked_.Bytes();
  return true;
}

}  // namespace ceilmap::bags
