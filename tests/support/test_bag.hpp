#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "app/bags/mcap_writer.hpp"
#include "app/bags/message_encoding.hpp"
#include "app/bags/message_types.hpp"

namespace ceilmap::support {

inline constexpr std::int64_t kSecondNs = 1'000'000'000;
/// When a bag begins: times of this century are long numbers.
inline constexpr std::int64_t kBagStartNs = 1'700'000'000 * kSecondNs;
inline constexpr double kBagStartS = 1.7e9;

/// A transform from the frame `child` to `parent`.
inline bags::TransformStamped Link(const std::string& parent,
                                   const std::string& child,
                                   const std::array<double, 3>& translation,
                                   const std::array<double, 4>& rotation = {0, 0, 0, 1},
                                   std::int64_t stamp_ns = kBagStartNs) {
  bags::TransformStamped link;
  link.header = {stamp_ns, parent};
  link.child_frame_id = child;
  link.transform = {translation, rotation};
  return link;
}

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
