#include "app/bags/topic_table.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace ceilmap::bags {

std::string Ros2TypeName(std::string_view type) {
  if (type == "tf/tfMessage") return "tf2_msgs/msg/TFMessage";
  const std::size_t slash = type.find('/');
  if (slash == std::string_view::npos || type.find('/', slash + 1) != std::string_view::npos) {
    return std::string(type);
  }
  return std::string(type.substr(0, slash)) + "/msg" + std::string(type.substr(slash));
}

std::uint32_t TopicTable::Add(const std::string& name,
                              const std::string& type,
                              MessageEncoding encoding) {
  const auto [found, added] = numbers_.try_emplace(std::tuple(name, type, encoding),
                                                   static_cast<std::uint32_t>(topics_.size()));
  if (added) topics_.push_back({name, type, encoding, std::nullopt});
  return found->second;
}

void TopicTable::Count(std::uint32_t number, std::int64_t messages) {
  std::optional<std::int64_t>& count = topics_[number].messages;
  const std::int64_t before = count.value_or(0);
  const std::int64_t most = std::numeric_limits<std::int64_t>::max() - before;
  count = before + std::clamp(messages, std::int64_t{0}, most);
}

void TopicTable::Sort() {
  std::vector<std::size_t> order(topics_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return topics_[a].name < topics_[b].name;
  });
  sorted_.clear();
  places_.resize(topics_.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    sorted_.push_back(topics_[order[i]]);
    places_[order[i]] = i;
  }
}

}  // namespace ceilmap::bags
