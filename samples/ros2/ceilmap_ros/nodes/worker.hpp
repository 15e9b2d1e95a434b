#pragma once

#include <chrono>
#include <functional>
#include <thread>
#include <utility>

#include "ceilmap_ros/logic/inbox.hpp"

namespace ceilmap_ros {

/// The thread that processes images, so that no callback waits for them.
class Worker {
 public:
  /// @param inbox  must outlive this. @param step  processes one image if one is ready; must not
  ///   throw.
  Worker(Inbox& inbox, std::function<void()> step)
      : inbox_(inbox), step_(std::move(step)), thread_([this] { Run(); }) {}
  ~Worker() {
    inbox_.Close();
    thread_.join();
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

 private:
  void Run() {
    // Images that wait for odometry in vain are looked at this often.
    constexpr std::chrono::milliseconds kPeriod(20);
    while (inbox_.Wait(kPeriod)) step_();
  }

  Inbox& inbox_;
  std::function<void()> step_;
  std::thread thread_;
};

}  // namespace ceilmap_ros
