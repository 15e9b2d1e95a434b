#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "app/terminal/table.hpp"

namespace ceilmap::reports {

/// The content of a bag.
struct BagContent {
  struct Topic {
    bags::Topic topic;
    std::int64_t messages = 0;
    std::optional<double> rate_hz;  ///< mean over the bag's duration; unset with one message
  };
  bags::BagFacts facts;
  double first_s = 0;  ///< times of recording; 0 without messages
  double last_s = 0;
  std::int64_t messages = 0;
  std::uintmax_t file_bytes = 0;  ///< of all files
  std::vector<Topic> topics;      ///< by name
  std::vector<std::string> warnings;
};

/// @throws InputError when the bag cannot be read. A bag without an index is read to its end.
BagContent InspectBag(const std::filesystem::path& bag);

nlohmann::ordered_json ToJson(const BagContent& content);
/// Facts of the bag, and a row for each topic.
terminal::Table FactsOf(const BagContent& content);
terminal::Table TopicsOf(const BagContent& content);

}  // namespace ceilmap::reports
