#include "app/recordings/bag_source.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "app/bags/message_types.hpp"
#include "calib/base/error.hpp"

namespace fs = std::filesystem;

namespace ceilmap::recordings {
namespace {

using bags::Topic;

struct UseFacts {
  std::vector<std::string_view> types;  // the preferred one first
  const char* name;
};

UseFacts FactsOf(TopicUse use) {
  switch (use) {
    case TopicUse::kOdometry:
      return {{bags::kOdometryType, bags::kTransformsType}, "odometry"};
    case TopicUse::kGyro:
      return {{bags::kImuType}, "a gyro"};
    case TopicUse::kImages:
      break;
  }
  return {{bags::kImageType, bags::kCompressedImageType}, "images"};
}

bool IsOf(const Topic& topic, const UseFacts& use) {
  return std::find(use.types.begin(), use.types.end(), topic.type) != use.types.end();
}

/// "/a (sensor_msgs/msg/Image), /b (...)"
std::string ListOf(const std::vector<Topic>& topics) {
  std::vector<std::string> names;
  names.reserve(topics.size());
  for (const Topic& topic : topics) {
    names.push_back(fmt::format("{} ({})", topic.name, topic.type));
  }
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

std::size_t FindNamed(const BagRecording& bag, const BagTopic& wanted, const UseFacts& use) {
  const std::vector<Topic>& topics = bag.Topics();
  const std::string name = wanted.topic.starts_with('/') ? wanted.topic : "/" + wanted.topic;
  const auto found = std::find_if(topics.begin(), topics.end(), [&](const Topic& topic) {
    return topic.name == name || topic.name == wanted.topic;
  });
  if (found == topics.end()) {
    throw InputError(fmt::format(
        "{}: has no topic {}; its topics are {}", bag.Name(), wanted.topic, ListOf(topics)));
  }
  if (!IsOf(*found, use)) {
    throw InputError(fmt::format("{}: {} holds messages of {}, must be {} for {}",
                                 bag.Name(),
                                 found->name,
                                 found->type,
                                 fmt::join(use.types, " or "),
                                 use.name));
  }
  return static_cast<std::size_t>(found - topics.begin());
}

// A transform is odometry only where its topic is named: /tf holds all kinds of them.
std::size_t FindOnly(const BagRecording& bag, const BagTopic& wanted, TopicUse use) {
  UseFacts facts = FactsOf(use);
  if (use == TopicUse::kOdometry) facts.types.resize(1);
  const std::vector<Topic>& topics = bag.Topics();
  std::vector<Topic> fitting;
  std::size_t index = 0;
  for (std::size_t i = 0; i < topics.size(); ++i) {
    if (!IsOf(topics[i], facts)) continue;
    fitting.push_back(topics[i]);
    index = i;
  }
  if (fitting.size() == 1) return index;
  if (fitting.empty()) {
    throw InputError(fmt::format("{}: has no topic of {} ({}); its topics are {}",
                                 bag.Name(),
                                 facts.name,
                                 fmt::join(facts.types, " or "),
                                 ListOf(topics)));
  }
  std::vector<std::string> names;
  names.reserve(fitting.size());
  for (const Topic& topic : fitting) names.push_back(topic.name);
  throw InputError(fmt::format("{}: has {} topics of {}, {}; choose one{}",
                               bag.Name(),
                               fitting.size(),
                               facts.name,
                               fmt::join(names, ", "),
                               wanted.option.empty() ? "" : " by " + wanted.option));
}

std::string PathOf(const std::string& bag) {
  std::error_code ignored;
  return fs::weakly_canonical(bag, ignored).string();
}

std::shared_ptr<BagRecording> RecordingFor(const std::string& bag, const BagTopic& topic) {
  return topic.bags ? topic.bags->Get(bag) : BagRecording::Open(bag);
}

}  // namespace

std::shared_ptr<BagRecording> OpenBags::Get(const std::string& bag) {
  std::shared_ptr<BagRecording>& open = bags_[PathOf(bag)];
  if (!open) open = BagRecording::Open(bag);
  return open;
}

const BagRobot& OpenBags::Robot(const std::string& bag) {
  const std::string path = PathOf(bag);
  const auto known = robots_.find(path);
  return known != robots_.end() ? known->second
                                : robots_.emplace(path, BagRobot::Read(bag)).first->second;
}

void OpenBags::ReleaseReserved() {
  for (const auto& [path, bag] : bags_) bag->ReleaseReserved();
}

bool IsBag(const std::string& source) {
  return source.find("://") == std::string::npos && bags::BagReader::IsBag(source);
}

std::size_t FindTopic(const BagRecording& bag, const BagTopic& topic, TopicUse use) {
  const std::size_t index =
      topic.topic.empty() ? FindOnly(bag, topic, use) : FindNamed(bag, topic, FactsOf(use));
  const Topic& found = bag.Topics()[index];
  if (found.encoding == bags::MessageEncoding::kOther) {
    throw InputError(fmt::format(
        "{}: the messages of {} are serialized neither as by ROS 2 (CDR) nor as by ROS 1; record "
        "the topic with rosbag",
        bag.Name(),
        found.name));
  }
  if (found.messages == 0) {
    throw InputError(fmt::format("{}: {} holds no messages", bag.Name(), found.name));
  }
  return index;
}

void ReserveTopic(const std::string& bag, const BagTopic& topic, TopicUse use) {
  const std::shared_ptr<BagRecording> recording = RecordingFor(bag, topic);
  recording->Reserve(FindTopic(*recording, topic, use));
}

std::unique_ptr<BagStream> OpenTopic(const std::string& bag, const BagTopic& topic, TopicUse use) {
  const std::shared_ptr<BagRecording> recording = RecordingFor(bag, topic);
  return recording->Subscribe(FindTopic(*recording, topic, use));
}

}  // namespace ceilmap::recordings
