#include "app/bags/warning_list.hpp"

#include <fmt/format.h>

#include <functional>

namespace ceilmap::bags {

void WarningList::Add(const std::string& text) {
  constexpr std::size_t kMaxLines = 10;
  constexpr std::size_t kMaxSeen = 100'000;
  if (seen_.size() == kMaxSeen || !seen_.insert(std::hash<std::string>()(text)).second) return;
  if (first_.size() < kMaxLines) first_.push_back(fmt::format("{}: {}", name_, text));
}

std::vector<std::string> WarningList::All() const {
  std::vector<std::string> all = first_;
  const std::size_t others = seen_.size() - first_.size();
  if (others > 0) all.push_back(fmt::format("{}: {} more problems", name_, others));
  return all;
}

}  // namespace ceilmap::bags
