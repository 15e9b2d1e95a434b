#include "app/recordings/live_queue.hpp"

#include <utility>

namespace ceilmap::recordings {

void LiveQueue::Push(Frame frame,
                     const std::optional<double>& time_s,
                     bool restarted,
                     std::vector<cv::Mat>& spare) {
  const StreamClock::Times times{frame.index, time_s, frame.arrival_s};
  if (restarted || clock_.Breaks(times)) {
    for (Waiting& waiting : waiting_) Stamp(waiting);
    clock_.Restart();
  }
  clock_.Arrive(times);
  if (waiting_.empty()) behind_since_s_ = frame.arrival_s;
  waiting_.push_back({std::move(frame), times, !params_.stamp});
  while (TooMany()) {
    spare.push_back(std::move(waiting_.front().frame.image));
    waiting_.pop_front();
    ++dropped_;
  }
}

bool LiveQueue::TooMany() const {
  if (waiting_.size() < 2) return false;
  const Frame& newest = waiting_.back().frame;
  const Frame& oldest = waiting_.front().frame;
  const bool behind = newest.arrival_s - behind_since_s_ > params_.max_behind_s;
  const double waited_s = newest.arrival_s - oldest.arrival_s;
  if (behind || params_.max_wait_s <= 0 || waited_s > params_.max_wait_s) return true;
  const std::size_t bytes = newest.image.total() * newest.image.elemSize();
  return waiting_.size() * bytes > params_.max_bytes;
}

void LiveQueue::Stamp(Waiting& waiting) {
  if (waiting.stamped) return;
  waiting.frame.stamp_s = clock_.Stamp(waiting.times);
  waiting.stamped = true;
}

bool LiveQueue::Ready(double now_s, bool ended) const {
  if (waiting_.empty()) return false;
  return ended || waiting_.front().stamped || clock_.Settled(now_s);
}

Frame LiveQueue::Take() {
  Stamp(waiting_.front());
  Frame frame = std::move(waiting_.front().frame);
  waiting_.pop_front();
  return frame;
}

}  // namespace ceilmap::recordings
