#pragma once

#include <cstddef>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

namespace ceilmap::bags {

/// Problems of a file, each once: the first ones, and the number of the others.
class WarningList {
 public:
  explicit WarningList(std::string name) : name_(std::move(name)) {}

  /// @param text  without the name of the file.
  void Add(const std::string& text);
  [[nodiscard]] std::vector<std::string> All() const;

 private:
  std::string name_;
  std::vector<std::string> first_;
  std::unordered_set<std::size_t> seen_;  // hashes
};

}  // namespace ceilmap::bags
