#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "app/bags/topic.hpp"

namespace ceilmap::bags {

/// "sensor_msgs/Image" becomes "sensor_msgs/msg/Image"; ROS 1's tf/tfMessage becomes ROS 2's
/// tf2_msgs/msg/TFMessage, which has the same fields.
std::string Ros2TypeName(std::string_view type);

/// The topics of a bag while they are collected: each has a number by the order in which it came,
/// and when all are there, a place in the order of names.
class TopicTable {
 public:
  /// @return the number of the topic, the same for the same name, type and encoding.
  std::uint32_t Add(const std::string& name, const std::string& type, MessageEncoding encoding);
  void Count(std::uint32_t number, std::int64_t messages);

  [[nodiscard]] const Topic& At(std::uint32_t number) const { return topics_[number]; }

  /// Ends the collection.
  void Sort();
  [[nodiscard]] const std::vector<Topic>& Sorted() const { return sorted_; }
  [[nodiscard]] std::size_t Place(std::uint32_t number) const { return places_[number]; }
  [[nodiscard]] std::size_t Size() const { return topics_.size(); }

 private:
  std::map<std::tuple<std::string, std::string, MessageEncoding>, std::uint32_t> numbers_;
  std::vector<Topic> topics_;
  std::vector<Topic> sorted_;
  std::vector<std::size_t> places_;
};

}  // namespace ceilmap::bags
