#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace ceilmap::recordings {

/// Results 0, 1, ... count - 1 of a job, computed by several threads and returned in order. Each
/// thread is at most two results ahead of the consumer, which bounds the memory.
template <typename Result>
class OrderedWork {
 public:
  using Job = std::function<Result(std::int64_t index)>;

  /// @param job  Called by several threads at once, once for each index.
  OrderedWork(std::int64_t count, int threads, Job job)
      : count_(count), max_ahead_(2 * threads), job_(std::move(job)) {
    for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Run(); });
  }
  /// Discards what has not begun and waits for the rest.
  ~OrderedWork() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    taken_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  OrderedWork(const OrderedWork&) = delete;
  OrderedWork& operator=(const OrderedWork&) = delete;

  /// The next result; nothing after the last one. Throws the exception of the job, if any.
  std::optional<Result> Next() {
    std::unique_lock lock(mutex_);
    if (next_out_ == count_) return std::nullopt;
    filled_.wait(lock, [this] { return done_.contains(next_out_); });
    Outcome outcome = std::move(done_.extract(next_out_).mapped());
    ++next_out_;
    lock.unlock();
    taken_.notify_all();
    if (outcome.error) std::rethrow_exception(outcome.error);
    return std::move(outcome.result);
  }

 private:
  struct Outcome {
    std::optional<Result> result;
    std::exception_ptr error;
  };

  void Run() {
    std::unique_lock lock(mutex_);
    while (true) {
      taken_.wait(lock, [this] {
        return stop_ || next_in_ == count_ || next_in_ - next_out_ < max_ahead_;
      });
      if (stop_ || next_in_ == count_) return;
      const std::int64_t index = next_in_++;
      lock.unlock();
      Outcome outcome;
      try {
        outcome.result = job_(index);
      } catch (...) {
        outcome.error = std::current_exception();
      }
      lock.lock();
      done_.emplace(index, std::move(outcome));
      filled_.notify_one();
    }
  }

  std::int64_t count_;
  std::int64_t max_ahead_;
  Job job_;

  std::mutex mutex_;  // guards the following members, except the threads
  std::condition_variable filled_;
  std::condition_variable taken_;
  std::map<std::int64_t, Outcome> done_;
  std::int64_t next_in_ = 0;   // next to begin
  std::int64_t next_out_ = 0;  // next to return
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace ceilmap::recordings
