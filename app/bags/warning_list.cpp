#include "app/bags/warning_list.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace ceilmap::bags {

void WarningList::Add(const std::string& text) {
  constexpr std::size_t kMost = 10;
  const std::string line = fmt::format("{}: {}", name_, text);
  if (std::find(first_.begin(), first_.end(), line) != first_.end()) return;
  if (first_.size() < kMost) {
    first_.push_back(line);
  } else {
    ++others_;
  }
}

std::vector<std::string> WarningList::All() const {
  std::vector<std::string> all = first_;
  if (others_ > 0) all.push_back(fmt::format("{}: {} more problems", name_, others_));
  return all;
}

}  // namespace ceilmap::bags
