#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace ceilmap {

/// A number of threads as options state it. @param threads  0: as many as the machine has cores.
inline int ThreadsFor(int threads) {
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  return std::max(1, threads > 0 ? threads : cores);
}

/// Runs work(0) .. work(count - 1) on up to `threads` threads, including the calling one. Each
/// index runs once, in no particular order. Rethrows the first exception, after which no further
/// index is started.
template <typename Work>
void ParallelFor(int count, int threads, const Work& work) {
  std::atomic<int> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto run = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int i = 1; i < std::min(threads, count); ++i) helpers.emplace_back(run);
    run();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace ceilmap
