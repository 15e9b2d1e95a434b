#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace ceilmap::registration {

/// Unused buffers of frames. A frame's buffers are megabytes: allocating them anew takes as long as
/// a transform. The blocks, which only few frames need, are not kept. Frames may outlive their
/// registrar and be destroyed in any thread.
template <typename Data>
class BufferPool {
 public:
  BufferPool() { free_.reserve(kMax); }

  /// A buffer that returns to the pool with its last owner.
  static std::shared_ptr<Data> Take(const std::shared_ptr<BufferPool>& pool) {
    std::unique_ptr<Data> data = pool->TakeFree();
    if (!data) data = std::make_unique<Data>();
    return {data.release(), [pool](Data* released) { pool->TakeBack(released); }};
  }

 private:
  static constexpr std::size_t kMax = 2;

  std::unique_ptr<Data> TakeFree() {
    const std::scoped_lock lock(mutex_);
    if (free_.empty()) return nullptr;
    std::unique_ptr<Data> data = std::move(free_.back());
    free_.pop_back();
    return data;
  }
  void TakeBack(Data* released) {
    std::unique_ptr<Data> data(released);
    data->ReleaseBlocks();
    const std::scoped_lock lock(mutex_);
    if (free_.size() < kMax) free_.push_back(std::move(data));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Data>> free_;
};

}  // namespace ceilmap::registration
