#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace ceilmap_ros {

/// One thread that runs long tasks in their order, so that no callback waits for them.
class TaskRunner {
 public:
  TaskRunner() : thread_([this] { Run(); }) {}
  /// Waits for the running task; those behind it are dropped.
  ~TaskRunner() {
    {
      const std::scoped_lock lock(mutex_);
      closed_ = true;
    }
    came_.notify_all();
    thread_.join();
  }
  TaskRunner(const TaskRunner&) = delete;
  TaskRunner& operator=(const TaskRunner&) = delete;

  /// @param task  must not throw.
  void Add(std::function<void()> task) {
    {
      const std::scoped_lock lock(mutex_);
      tasks_.push_back(std::move(task));
    }
    came_.notify_all();
  }

 private:
  void Run() {
    std::unique_lock lock(mutex_);
    while (true) {
      came_.wait(lock, [this] { return closed_ || !tasks_.empty(); });
      if (closed_) return;
      const std::function<void()> task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      task();
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<std::function<void()>> tasks_;
  bool closed_ = false;
  std::thread thread_;
};

}  // namespace ceilmap_ros
