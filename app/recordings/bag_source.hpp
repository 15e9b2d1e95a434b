#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "app/recordings/bag_recording.hpp"
#include "app/recordings/bag_robot.hpp"
#include "app/recordings/message_times.hpp"

namespace ceilmap::recordings {

/// What a consumer reads a topic for.
enum class TopicUse : std::uint8_t {
  kImages,    ///< sensor_msgs/msg/Image, sensor_msgs/msg/CompressedImage
  kOdometry,  ///< nav_msgs/msg/Odometry; tf2_msgs/msg/TFMessage where it is named
  kGyro,      ///< sensor_msgs/msg/Imu
};

/// The bags of a run, so that each is read once for all of its topics.
class OpenBags {
 public:
  /// Opens a bag, or returns the one that is open. @throws InputError
  std::shared_ptr<BagRecording> Get(const std::string& bag);
  /// What a bag says of its robot; read once. @throws InputError
  const BagRobot& Robot(const std::string& bag);
  /// BagRecording::ReleaseReserved of all.
  void ReleaseReserved();

 private:
  // By their paths.
  std::map<std::string, std::shared_ptr<BagRecording>> bags_;
  std::map<std::string, BagRobot> robots_;
};

/// One topic of a bag, where SOURCE is a bag.
struct BagTopic {
  std::string topic = {};   ///< empty: the only one of its use
  std::string option = {};  ///< that chooses the topic, for messages: "--up-topic"
  BagStamp stamp = BagStamp::kHeader;
  std::shared_ptr<OpenBags> bags = nullptr;  ///< those of the run; null: it is read alone
};

/// True when SOURCE of the command line is a bag.
bool IsBag(const std::string& source);

/// The topic that is meant. @return its index among the topics of the bag.
/// @throws InputError where it does not exist, is of another type or encoding, or is not unique.
std::size_t FindTopic(const BagRecording& bag, const BagTopic& topic, TopicUse use);

/// Says that the topic of a bag will be read (BagRecording::Reserve). @throws as FindTopic.
void ReserveTopic(const std::string& bag, const BagTopic& topic, TopicUse use);

/// The messages of the topic. @throws InputError as FindTopic, or when the bag cannot be opened.
std::unique_ptr<BagStream> OpenTopic(const std::string& bag, const BagTopic& topic, TopicUse use);

}  // namespace ceilmap::recordings
