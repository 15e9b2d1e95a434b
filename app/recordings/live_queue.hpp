#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "app/recordings/frame.hpp"
#include "app/recordings/stream_clock.hpp"

namespace ceilmap::recordings {

struct LiveQueueParams {
  /// Longest time that a frame waits while newer ones arrive, seconds, >= 0: the oldest frames are
  /// dropped. 0: only the newest frame waits.
  double max_wait_s = 2;
  /// Once frames have waited without a break for this time, seconds, only the newest one waits
  /// until the consumer has caught up: late frames are of no use to a consumer that stays too slow.
  double max_behind_s = std::numeric_limits<double>::infinity();
  std::size_t max_bytes = std::size_t{256} << 20U;  ///< of the waiting images
  bool stamp = true;        ///< frames get the stamps of a StreamClock; false: they have theirs
  bool same_clock = false;  ///< see StreamClock
};

/// The frames of a live source that wait for their consumer. A consumer that is busy for a moment
/// loses nothing; one that is too slow loses the oldest frames. Not thread-safe.
class LiveQueue {
 public:
  explicit LiveQueue(const LiveQueueParams& params = {})
      : params_(params), clock_(params.same_clock) {}

  /// Adds a frame with its index and arrival, in the order of the stream.
  /// @param time_s  Its presentation time, if it has one.
  /// @param restarted  The source was opened again before this frame.
  /// @param spare  Receives the images of dropped frames.
  void Push(Frame frame,
            const std::optional<double>& time_s,
            bool restarted,
            std::vector<cv::Mat>& spare);
  /// True when Take may be called. At the start, frames are held back until their stamps are known
  /// (StreamClock::Settled). @param ended  No frame will be added any more.
  [[nodiscard]] bool Ready(double now_s, bool ended) const;
  /// The oldest frame, with its stamp.
  Frame Take();

  [[nodiscard]] bool Empty() const { return waiting_.empty(); }
  [[nodiscard]] std::int64_t Dropped() const { return dropped_; }
  [[nodiscard]] std::optional<std::int64_t> Missing() const { return clock_.Missing(); }

 private:
  struct Waiting {
    Frame frame;
    StreamClock::Times times;
    bool stamped = false;
  };
  void Stamp(Waiting& waiting);
  [[nodiscard]] bool TooMany() const;

  LiveQueueParams params_;
  StreamClock clock_;
  std::deque<Waiting> waiting_;
  double behind_since_s_ = 0;  // arrival of the first frame that found others waiting
  std::int64_t dropped_ = 0;
};

}  // namespace ceilmap::recordings
