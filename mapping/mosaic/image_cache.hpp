#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>

#include "calib/base/lru_cache.hpp"

namespace ceilmap::mosaic {

/// Cache of the most recently used images, up to a given number. Thread-safe; the loader runs one
/// call at a time, and other threads can read cached images meanwhile.
class ImageCache {
 public:
  using Image = std::shared_ptr<const cv::Mat>;
  using Loader = std::function<cv::Mat(std::int64_t id)>;

  /// @param capacity  images kept, at least 1. Images in use stay valid after their removal.
  ImageCache(Loader loader, int capacity);

  /// The image, never null. Rethrows exceptions of the loader.
  [[nodiscard]] Image Get(std::int64_t id);

 private:
  [[nodiscard]] Image Find(std::int64_t id);

  Loader loader_;
  std::mutex load_mutex_;
  std::mutex mutex_;  // guards the members below
  LruCache<Image> images_;
};

}  // namespace ceilmap::mosaic
