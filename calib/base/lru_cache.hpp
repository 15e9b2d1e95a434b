#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <unordered_map>
#include <utility>

namespace ceilmap {

/// The values used last, up to a number. Not thread-safe.
template <typename Value>
class LruCache {
 public:
  /// @param capacity  values kept, at least 1.
  explicit LruCache(std::size_t capacity) : capacity_(capacity) {}

  /// The value, which becomes the latest used; null when it is not here. Valid until the next call.
  [[nodiscard]] const Value* Find(std::int64_t id) {
    const auto found = index_.find(id);
    if (found == index_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found->second);
    return &entries_.front().second;
  }

  /// Takes a value that is not here yet, and drops the one that was used longest ago.
  void Insert(std::int64_t id, Value value) {
    entries_.emplace_front(id, std::move(value));
    index_[id] = entries_.begin();
    if (entries_.size() <= capacity_) return;
    index_.erase(entries_.back().first);
    entries_.pop_back();
  }

 private:
  using Entry = std::pair<std::int64_t, Value>;
  std::size_t capacity_;
  std::list<Entry> entries_;  // latest use first
  std::unordered_map<std::int64_t, typename std::list<Entry>::iterator> index_;
};

}  // namespace ceilmap
