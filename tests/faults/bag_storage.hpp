#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tests/faults/motion.hpp"

namespace ceilmap::faults {

/// A message of a drive's bag: /up/image_raw, /odom or /imu.
struct BagMessage {
  std::string topic;
  std::string_view type;
  std::int64_t log_ns = 0;  ///< 20 ms after its stamp
  std::vector<std::uint8_t> bytes;
};
using BagMessages = std::vector<BagMessage>;

/// The drive as messages of ROS 2, by their log time.
BagMessages MessagesOf(const Recording& recording, const Motion& motion);

/// MCAP for a name that ends in .mcap, otherwise the database of rosbag2.
void WriteBag(const BagMessages& messages, const std::filesystem::path& bag);

// What can go wrong with messages, as recording_faults.hpp.

/// This share of all messages is missing.
void DropMessages(BagMessages& messages, double share, Random& random);
/// This share of all messages comes twice.
void DuplicateMessages(BagMessages& messages, double share, Random& random);
/// The topic has no stamps: they are 0, and its messages are recorded without delay.
void ClearStamps(BagMessages& messages, const std::string& topic);
/// This share of all messages is recorded up to half a second later.
void DelayMessages(BagMessages& messages, double share, Random& random);

}  // namespace ceilmap::faults
