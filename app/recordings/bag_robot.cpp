#include "app/recordings/bag_robot.hpp"

#include <limits>
#include <string_view>
#include <utility>

#include "app/bags/message_error.hpp"
#include "app/bags/message_types.hpp"

namespace ceilmap::recordings {
namespace {

std::vector<std::size_t> TopicsOf(const bags::BagReader& reader, std::string_view type) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < reader.Topics().size(); ++i) {
    const bags::Topic& topic = reader.Topics()[i];
    if (topic.type != type || topic.encoding == bags::MessageEncoding::kOther) continue;
    if (topic.messages != 0) found.push_back(i);
  }
  return found;
}

void ReadFrames(bags::BagReader& reader, FrameTree& frames) {
  constexpr std::int64_t kLongestNs = 10'000'000'000;
  std::vector<std::size_t> topics = TopicsOf(reader, bags::kTransformsType);
  std::erase_if(topics, [&reader](std::size_t topic) {
    return !reader.Topics()[topic].name.ends_with("tf_static");
  });
  if (topics.empty()) return;
  std::int64_t expected = 0;
  for (const std::size_t topic : topics) {
    const auto messages = reader.Topics()[topic].messages;
    expected += messages.value_or(std::numeric_limits<std::int32_t>::max());
  }
  reader.Select(topics);
  std::optional<std::int64_t> first_ns;
  bags::RawMessage message;
  for (std::int64_t read = 0; read < expected && reader.Next(message); ++read) {
    if (!first_ns) first_ns = message.log_time_ns;
    if (message.log_time_ns - *first_ns > kLongestNs) return;
    try {
      const bags::Topic& topic = reader.Topics()[message.topic];
      for (const auto& transform : bags::DecodeTransforms(message.data, topic.encoding)) {
        frames.Add(transform);
      }
    } catch (const bags::MessageError&) {
      continue;  // what it says is missing, and named where it is needed
    }
  }
}

void ReadCameras(bags::BagReader& reader, std::map<std::string, BagCamera>& cameras) {
  const std::vector<std::size_t> topics = TopicsOf(reader, bags::kCameraInfoType);
  if (topics.empty()) return;
  reader.Select(topics);
  bags::RawMessage message;
  while (cameras.size() < topics.size() && reader.Next(message)) {
    const bags::Topic& topic = reader.Topics()[message.topic];
    if (cameras.contains(topic.name)) continue;
    try {
      cameras[topic.name] = {topic.name, bags::DecodeCameraInfo(message.data, topic.encoding)};
    } catch (const bags::MessageError& error) {
      continue;
    }
  }
}

}  // namespace

BagRobot BagRobot::Read(const std::string& bag) {
  return Read(bag, *bags::BagReader::Open(bag));
}

BagRobot BagRobot::Read(std::string name, bags::BagReader& reader) {
  BagRobot robot;
  robot.name_ = std::move(name);
  ReadFrames(reader, robot.frames_);
  ReadCameras(reader, robot.cameras_);
  return robot;
}

const BagCamera* BagRobot::CameraOf(const std::string& image_topic) const {
  // Each level of names: /up/image_raw/compressed has it at /up/camera_info.
  std::string name = image_topic;
  while (name.rfind('/') != std::string::npos) {
    name.resize(name.rfind('/'));
    const auto found = cameras_.find(name + "/camera_info");
    if (found != cameras_.end()) return &found->second;
    if (!name.ends_with("image_raw")) break;
  }
  return nullptr;
}

}  // namespace ceilmap::recordings
