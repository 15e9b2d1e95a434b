#include "tests/faults/bag_storage.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "app/bags/mcap_writer.hpp"
#include "app/bags/message_encoding.hpp"
#include "app/bags/message_types.hpp"
#include "tests/support/sqlite_file.hpp"

namespace fs = std::filesystem;

namespace ceilmap::faults {
namespace {

constexpr std::int64_t kLateNs = 20'000'000;

bool Chance(double share, Random& random) {
  return std::uniform_real_distribution<double>(0, 1)(random) < share;
}

void Sort(BagMessages& messages) {
  std::stable_sort(messages.begin(), messages.end(), [](const BagMessage& a, const BagMessage& b) {
    return a.log_ns < b.log_ns;
  });
}

template <typename Message>
void Add(BagMessages& messages,
         const std::string& topic,
         std::string_view type,
         std::int64_t stamp_ns,
         const Message& message) {
  messages.push_back({topic, type, stamp_ns + kLateNs, bags::Encode(message)});
}

void WriteDatabase(const BagMessages& messages, const fs::path& bag) {
  support::SqliteFile file(bag, support::kRosbag2Schema);
  file.Run("BEGIN");
  std::map<std::string, int> topics;
  for (const BagMessage& message : messages) {
    const auto [topic, is_new] =
        topics.try_emplace(message.topic, static_cast<int>(topics.size()) + 1);
    if (is_new) {
      file.Run("INSERT INTO topics VALUES(" + std::to_string(topic->second) + ", '" +
               message.topic + "', '" + std::string(message.type) + "', 'cdr', '')");
    }
    file.Add(topic->second, message.log_ns, {message.bytes.begin(), message.bytes.end()});
  }
  file.Run("COMMIT");
}

}  // namespace

BagMessages MessagesOf(const Recording& recording, const Motion& motion) {
  BagMessages messages;
  for (const Shot& shot : recording) {
    const std::int64_t stamp_ns = bags::Nanoseconds(shot.stamp_s);
    const auto width = static_cast<std::uint32_t>(shot.image.cols);
    Add(messages,
        "/up/image_raw",
        bags::kImageType,
        stamp_ns,
        bags::ImageMessage{{stamp_ns, "up"},
                           static_cast<std::uint32_t>(shot.image.rows),
                           width,
                           "mono8",
                           false,
                           width,
                           {shot.image.data, shot.image.total()}});
  }
  for (const simulator::WheelSample& sample : motion.wheels) {
    const std::int64_t stamp_ns = bags::Nanoseconds(sample.stamp_s);
    const double half = sample.T_odom_base.yaw / 2;
    bags::OdometryMessage odometry;
    odometry.header = {stamp_ns, "odom"};
    odometry.child_frame_id = "base_link";
    odometry.pose = {{sample.T_odom_base.x, sample.T_odom_base.y, 0},
                     {0, 0, std::sin(half), std::cos(half)}};
    Add(messages, "/odom", bags::kOdometryType, stamp_ns, odometry);
  }
  for (const simulator::GyroSample& sample : motion.gyro) {
    const std::int64_t stamp_ns = bags::Nanoseconds(sample.stamp_s);
    Add(messages,
        "/imu",
        bags::kImuType,
        stamp_ns,
        bags::ImuMessage{{stamp_ns, "base_link"}, {0, 0, sample.omega_z_rad_s}});
  }
  Sort(messages);
  return messages;
}

void WriteBag(const BagMessages& messages, const fs::path& bag) {
  fs::remove(bag);
  if (bag.extension() != ".mcap") {
    WriteDatabase(messages, bag);
    return;
  }
  bags::McapWriter writer(bag);
  std::map<std::string, bags::McapWriter::ChannelId> channels;
  for (const BagMessage& message : messages) {
    const auto known = channels.find(message.topic);
    const auto channel = known != channels.end()
                             ? known->second
                             : (channels[message.topic] = writer.Add(message.topic, message.type));
    writer.Write(channel, message.log_ns, message.bytes);
  }
  writer.Commit();
}

void DropMessages(BagMessages& messages, double share, Random& random) {
  std::erase_if(messages, [&](const BagMessage&) { return Chance(share, random); });
}

void DuplicateMessages(BagMessages& messages, double share, Random& random) {
  BagMessages all;
  all.reserve(2 * messages.size());
  for (const BagMessage& message : messages) {
    all.push_back(message);
    if (Chance(share, random)) all.push_back(message);
  }
  messages = std::move(all);
}

void ClearStamps(BagMessages& messages, const std::string& topic) {
  // A stamp is behind the four bytes that state the encoding: 4 bytes of seconds, 4 of nanoseconds.
  constexpr int kBegin = 4;
  constexpr int kBytes = 8;
  for (BagMessage& message : messages) {
    if (message.topic != topic) continue;
    std::fill_n(message.bytes.begin() + kBegin, kBytes, std::uint8_t{0});
    message.log_ns -= kLateNs;
  }
}

void DelayMessages(BagMessages& messages, double share, Random& random) {
  constexpr double kMaxNs = 5e8;
  for (BagMessage& message : messages) {
    if (!Chance(share, random)) continue;
    message.log_ns +=
        static_cast<std::int64_t>(std::uniform_real_distribution<double>(0, kMaxNs)(random));
  }
  Sort(messages);
}

}  // namespace ceilmap::faults
