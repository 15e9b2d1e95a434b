#include "ceilmap_ros/logic/frame_queue.hpp"

#include <utility>

namespace ceilmap_ros {

void FrameQueue::Add(WaitingFrame frame) {
  constexpr std::size_t kLongest = 30;
  frames_.push_back(std::move(frame));
  if (frames_.size() <= kLongest) return;
  frames_.pop_front();
  ++dropped_;
}

void FrameQueue::Clear() {
  dropped_ += static_cast<std::int64_t>(frames_.size());
  frames_.clear();
}

std::optional<WaitingFrame> FrameQueue::TakeReady(std::optional<Stamp> complete_until,
                                                  Stamp now,
                                                  Stamp longest_wait) {
  const auto is_ready = [&](const WaitingFrame& frame) {
    if (!complete_until || frame.stamp <= *complete_until) return true;
    // A clock that stepped back does not let images wait for ever.
    return now - frame.arrival >= longest_wait || now < frame.arrival;
  };
  std::optional<WaitingFrame> ready;
  while (!frames_.empty() && is_ready(frames_.front())) {
    if (ready) ++dropped_;
    ready = std::move(frames_.front());
    frames_.pop_front();
  }
  return ready;
}

}  // namespace ceilmap_ros
