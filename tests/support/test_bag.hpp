#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "app/bags/mcap_writer.hpp"
#include "app/bags/message_encoding.hpp"
#include "app/bags/message_types.hpp"

namespace ceilmap::support {

/// An MCAP file with messages of ROS 2.
class TestBag {
 public:
  explicit TestBag(const std::filesystem::path& file, const bags::McapOptions& options = {})
      : writer_(file, options) {}

  template <typename Message>
  void Write(const std::string& topic,
             std::string_view type,
             std::int64_t log_time_ns,
             const Message& message) {
    const auto known = channels_.find(topic);
    const auto channel =
        known != channels_.end() ? known->second : (channels_[topic] = writer_.Add(topic, type));
    writer_.Write(channel, log_time_ns, bags::Encode(message));
  }
  void Commit() { writer_.Commit(); }

 private:
  bags::McapWriter writer_;
  std::map<std::string, bags::McapWriter::ChannelId> channels_;
};

}  // namespace ceilmap::support
