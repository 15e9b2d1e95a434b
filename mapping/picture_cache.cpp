#include "mapping/picture_cache.hpp"

#include <algorithm>

namespace ceilmap::mapping {

PictureCache::PictureCache(Loader loader, int capacity)
    : loader_(std::move(loader)), capacity_(static_cast<std::size_t>(std::max(capacity, 1))) {}

PictureCache::Picture PictureCache::Get(std::int64_t id) {
  if (Picture picture = Find(id)) return picture;
  const std::lock_guard loading(load_mutex_);
  // Another thread may have loaded it while this one waited.
  if (Picture picture = Find(id)) return picture;
  auto picture = std::make_shared<const cv::Mat>(loader_(id));
  Insert(id, picture);
  return picture;
}

PictureCache::Picture PictureCache::Find(std::int64_t id) {
  const std::lock_guard lock(mutex_);
  const auto found = index_.find(id);
  if (found == index_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, found->second);
  return found->second->picture;
}

void PictureCache::Insert(std::int64_t id, const Picture& picture) {
  const std::lock_guard lock(mutex_);
  entries_.push_front({id, picture});
  index_[id] = entries_.begin();
  if (entries_.size() > capacity_) {
    index_.erase(entries_.back().id);
    entries_.pop_back();
  }
}

}  // namespace ceilmap::mapping
