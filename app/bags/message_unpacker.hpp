#pragma once

#include "app/bags/bag_reader.hpp"
#include "app/bags/byte_file.hpp"
#include "app/bags/warning_list.hpp"

namespace ceilmap::bags {

/// Decompresses the messages that rosbag2 compressed one by one (compression_mode "message").
class MessageUnpacker {
 public:
  /// A message of CDR that is compressed is replaced by what it was.
  /// @return false when it cannot be decompressed, with a warning: the message is skipped.
  bool Unpack(RawMessage& message, const Topic& topic, WarningList& warnings);

 private:
  Buffer unpacked_;
};

}  // namespace ceilmap::bags
