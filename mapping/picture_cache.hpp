#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <mutex>
#include <opencv2/core.hpp>
#include <unordered_map>

namespace ceilmap::mapping {

/// The pictures used last, up to a number. Thread-safe; the loader runs one call at a time, and
/// meanwhile other threads get what is already there.
class PictureCache {
 public:
  using Loader = std::function<cv::Mat(std::int64_t id)>;

  /// @param capacity  pictures kept, at least 1. Pictures in use live on outside of it.
  PictureCache(Loader loader, int capacity);

  /// The picture, shared: not to be written to. Throws what the loader throws.
  [[nodiscard]] cv::Mat Get(std::int64_t id);

 private:
  [[nodiscard]] cv::Mat Find(std::int64_t id);
  void Insert(std::int64_t id, const cv::Mat& picture);

  struct Entry {
    std::int64_t id;
    cv::Mat picture;
  };
  Loader loader_;
  std::size_t capacity_;
  std::mutex load_mutex_;
  std::mutex mutex_;          // of what follows
  std::list<Entry> entries_;  // latest use first
  std::unordered_map<std::int64_t, std::list<Entry>::iterator> index_;
};

}  // namespace ceilmap::mapping
