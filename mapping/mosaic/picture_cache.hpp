#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>

#include "calib/base/lru_cache.hpp"

namespace ceilmap::mosaic {

/// The pictures used last, up to a number. Thread-safe; the loader runs one call at a time, and
/// meanwhile other threads get what is already there.
class PictureCache {
 public:
  using Picture = std::shared_ptr<const cv::Mat>;
  using Loader = std::function<cv::Mat(std::int64_t id)>;

  /// @param capacity  pictures kept, at least 1. Pictures in use live on outside of it.
  PictureCache(Loader loader, int capacity);

  /// The picture, never null. Throws what the loader throws.
  [[nodiscard]] Picture Get(std::int64_t id);

 private:
  [[nodiscard]] Picture Find(std::int64_t id);

  Loader loader_;
  std::mutex load_mutex_;
  std::mutex mutex_;  // of what follows
  LruCache<Picture> pictures_;
};

}  // namespace ceilmap::mosaic
