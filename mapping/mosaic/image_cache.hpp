#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>

#include "calib/base/lru_cache.hpp"

namespace ceilmap::mosaic {

/// The images used last, up to a number. Thread-safe; the loader runs one call at a time, and
/// meanwhile other threads get what is already there.
class ImageCache {
 public:
  using Image = std::shared_ptr<const cv::Mat>;
  using Loader = std::function<cv::Mat(std::int64_t id)>;

  /// @param capacity  images kept, at least 1. Images in use live on outside of it.
  ImageCache(Loader loader, int capacity);

  /// The image, never null. Throws what the loader throws.
  [[nodiscard]] Image Get(std::int64_t id);

 private:
  [[nodiscard]] Image Find(std::int64_t id);

  Loader loader_;
  std::mutex load_mutex_;
  std::mutex mutex_;  // of what follows
  LruCache<Image> images_;
};

}  // namespace ceilmap::mosaic
