#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <list>
#include <unordered_map>
#include <utility>

namespace ceilmap {

/// Cache of the most recently used values, up to a fixed number. Not thread-safe.
template <typename Value>
class LruCache {
 public:
  /// @param capacity maximum number of values, at least 1.
  explicit LruCache(std::size_t capacity) : capacity_(capacity) {}

  /// The value, which becomes the most recently used; null when it is not in the cache. The pointer
  /// is valid until the next call.
  [[nodiscard]] const Value* Find(std::int64_t id) {
    const auto found = index_.find(id);
    if (found == index_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found->second);
    return &entries_.front().second;
  }

  /// Adds a value that is not in the cache yet. When the cache is full, the least recently used
  /// value is removed.
  void Insert(std::int64_t id, Value value) {
    entries_.emplace_front(id, std::move(value));
    index_[id] = entries_.begin();
    if (entries_.size() <= capacity_) return;
    index_.erase(entries_.back().first);
    entries_.pop_back();
  }

  /// Calls use(value) for all but the `count` most recently used values. It may change them.
  template <typename Use>
  void ForEachBut(std::size_t count, const Use& use) {
    if (entries_.size() <= count) return;
    auto entry = std::next(entries_.begin(), static_cast<std::ptrdiff_t>(count));
    for (; entry != entries_.end(); ++entry) use(entry->second);
  }

 private:
  using Entry = std::pair<std::int64_t, Value>;
  std::size_t capacity_;
  std::list<Entry> entries_;  // most recently used first
  std::unordered_map<std::int64_t, typename std::list<Entry>::iterator> index_;
};

}  // namespace ceilmap
