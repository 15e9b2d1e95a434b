#include "app/recordings/bag_options.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "calib/base/error.hpp"

namespace ceilmap::recordings {
namespace {

const std::map<std::string, std::string> kContents = {
    {"up", "Images of the upward camera"},
    {"forward", "Images of the forward camera"},
    {"omni", "Images of the mirror camera"},
    {"image", "Images"},
    {"odometry", "Wheel odometry (nav_msgs/Odometry, or tf2_msgs/TFMessage to base_link)"},
    {"gyro", "Turn rates (sensor_msgs/Imu)"}};
const std::map<std::string, std::string> kCameras = {
    {"up", "upward camera"}, {"forward", "forward camera"}, {"omni", "mirror camera"}};

}  // namespace

void BagOptions::AddTo(CLI::App& cli, const std::vector<std::string>& sources) {
  const std::string group = "Bags";
  for (const std::string& source : sources) {
    const std::string text =
        source == sources.front()
            ? fmt::format("{} in a bag [the only ones]", kContents.at(source))
            : fmt::format("{} in a bag: in that of the {} where no other is given",
                          kContents.at(source),
                          kCameras.at(sources.front()));
    cli.add_option(fmt::format("--{}-topic", source), topics_[source], text)
        ->type_name("TOPIC")
        ->group(group);
  }
  cli.add_option("--stamp",
                 stamp_,
                 "Time of a bag's messages: header, when they were measured; log, when they were "
                 "recorded")
      ->check(CLI::IsMember({"header", "log"}))
      ->capture_default_str()
      ->type_name("TIME")
      ->group(group);
}

void BagOptions::CheckMain(const std::string& source, const std::string& given) const {
  const auto topic = topics_.find(source);
  std::error_code ignored;
  if (topic == topics_.end() || topic->second.empty() || IsBag(given)) return;
  if (!std::filesystem::exists(given, ignored)) return;  // its own message follows
  throw InputError(
      fmt::format("--{}-topic: {} is no bag, which has topics; leave it out", source, given));
}

std::string BagOptions::Complete(const std::string& source,
                                 const std::string& given,
                                 const std::string& main_option,
                                 const std::string& main) const {
  if (!given.empty()) {
    CheckMain(source, given);
    return given;
  }
  const auto topic = topics_.find(source);
  if (topic == topics_.end() || topic->second.empty()) return "";
  std::error_code ignored;
  if (!IsBag(main) && std::filesystem::exists(main, ignored)) {
    throw InputError(fmt::format(
        "--{}-topic: {} of --{} is no bag, and no other is given; leave it out, or name the bag",
        source,
        main,
        main_option));
  }
  return main;
}

BagTopic BagOptions::Topic(const std::string& source) const {
  const auto topic = topics_.find(source);
  return {topic == topics_.end() ? "" : topic->second,
          fmt::format("--{}-topic", source),
          stamp_ == "log" ? BagStamp::kLog : BagStamp::kHeader,
          bags_};
}

BagTopic BagOptions::TopicAlone(const std::string& source) const {
  BagTopic topic = Topic(source);
  topic.bags = nullptr;
  return topic;
}

}  // namespace ceilmap::recordings
