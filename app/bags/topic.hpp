#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ceilmap::bags {

/// How the messages of a topic are serialized.
enum class MessageEncoding {
  kCdr,    ///< ROS 2: Common Data Representation (OMG DDS-XTypes 7.4), either byte order
  kRos1,   ///< ROS 1: little endian, packed
  kOther,  ///< JSON, Protobuf, ...; not decoded
};

/// A topic of a bag. A topic that is recorded by several connections or in several files of a bag
/// is one topic.
struct Topic {
  std::string name;  ///< "/ceiling/image_raw"
  std::string type;  ///< as ROS 2 writes it, "sensor_msgs/msg/Image"; of ROS 1 too
  MessageEncoding encoding = MessageEncoding::kCdr;
  std::optional<std::int64_t> messages;  ///< their number; unset where the index does not state it
};

}  // namespace ceilmap::bags
