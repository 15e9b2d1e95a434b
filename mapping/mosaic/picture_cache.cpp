#include "mapping/mosaic/picture_cache.hpp"

#include <algorithm>

namespace ceilmap::mosaic {

PictureCache::PictureCache(Loader loader, int capacity)
    : loader_(std::move(loader)), pictures_(static_cast<std::size_t>(std::max(capacity, 1))) {}

PictureCache::Picture PictureCache::Get(std::int64_t id) {
  if (Picture picture = Find(id)) return picture;
  const std::lock_guard loading(load_mutex_);
  // Another thread may have loaded it while this one waited.
  if (Picture picture = Find(id)) return picture;
  auto picture = std::make_shared<const cv::Mat>(loader_(id));
  const std::lock_guard lock(mutex_);
  pictures_.Insert(id, picture);
  return picture;
}

PictureCache::Picture PictureCache::Find(std::int64_t id) {
  const std::lock_guard lock(mutex_);
  const Picture* found = pictures_.Find(id);
  return found != nullptr ? *found : nullptr;
}

}  // namespace ceilmap::mosaic
