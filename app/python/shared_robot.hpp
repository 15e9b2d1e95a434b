#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "calib/base/error.hpp"
#include "localization/robot/sensors.hpp"

namespace ceilmap::python {

namespace py = pybind11;

/// A mapper or localizer that Python's threads share: they wait for each other's calls, without
/// Python's lock.
class SharedRobot {
 public:
  virtual ~SharedRobot() = default;
  SharedRobot(const SharedRobot&) = delete;
  SharedRobot& operator=(const SharedRobot&) = delete;

  /// Runs `work(sensors)`, which must not touch Python's objects, while other threads of Python
  /// run.
  /// @throws RunError after End, and when called from the call that this thread is in (a progress
  ///   function).
  template <typename Work>
  auto Run(const Work& work) {
    const py::gil_scoped_release unlocked;
    const Call call(*this);
    if (ended_ != nullptr) throw RunError(ended_);
    return work(Sensors());
  }

  /// The number of an image: the given one, or one more than that of the image before.
  std::int64_t NextIndex(std::optional<std::int64_t> index) {
    const std::int64_t number = index.value_or(next_index_);
    next_index_ = number + 1;
    return number;
  }

 protected:
  SharedRobot() = default;

  [[nodiscard]] virtual robot::Sensors& Sensors() = 0;
  /// No calls any more. @param reason  a literal, for messages. Within Run.
  void End(const char* reason) { ended_ = reason; }

 private:
  class Call {
   public:
    explicit Call(SharedRobot& robot) : robot_(robot) {
      if (robot.caller_ == std::this_thread::get_id()) {
        throw RunError("a progress function must not call the object whose progress it shows");
      }
      lock_ = std::unique_lock(robot.mutex_);
      robot.caller_ = std::this_thread::get_id();
    }
    ~Call() { robot_.caller_ = std::thread::id(); }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

   private:
    SharedRobot& robot_;
    std::unique_lock<std::mutex> lock_;
  };

  std::mutex mutex_;
  std::atomic<std::thread::id> caller_;
  const char* ended_ = nullptr;
  std::int64_t next_index_ = 0;
};

}  // namespace ceilmap::python
