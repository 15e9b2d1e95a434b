#include "mapping/mosaic/image_cache.hpp"

#include <algorithm>

namespace ceilmap::mosaic {

ImageCache::ImageCache(Loader loader, int capacity)
    : loader_(std::move(loader)), images_(static_cast<std::size_t>(std::max(capacity, 1))) {}

ImageCache::Image ImageCache::Get(std::int64_t id) {
  if (Image image = Find(id)) return image;
  const std::lock_guard loading(load_mutex_);
  // Another thread may have loaded the image while this one waited.
  if (Image image = Find(id)) return image;
  auto image = std::make_shared<const cv::Mat>(loader_(id));
  const std::lock_guard lock(mutex_);
  images_.Insert(id, image);
  return image;
}

ImageCache::Image ImageCache::Find(std::int64_t id) {
  const std::lock_guard lock(mutex_);
  const Image* found = images_.Find(id);
  return found != nullptr ? *found : nullptr;
}

}  // namespace ceilmap::mosaic
