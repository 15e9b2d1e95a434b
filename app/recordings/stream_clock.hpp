#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace ceilmap::recordings {

/// Time stamps of the frames of a live source, in seconds of this machine's clock.
///
/// A stream has its own time, with an arbitrary zero: the presentation times of its frames. A delay
/// between sender and this machine only adds to the time of arrival. So the zero is where the
/// smallest difference between arrival and presentation time of the last 5 to 10 seconds puts it:
/// jitter of the network does not reach the stamps, and a sender's clock that is fast or slow is
/// followed. The part of the delay that all frames have in common cannot be measured and remains in
/// the stamps.
///
/// Stamps increase strictly. Where the zero moves, the interval between two frames differs from
/// that of the presentation times by at most half of it, until the stamps are in agreement again.
class StreamClock {
 public:
  /// A frame's times.
  struct Times {
    std::int64_t index = 0;        ///< counts the frames, with damaged and dropped ones
    std::optional<double> time_s;  ///< presentation time; unset: unknown
    double arrival_s = 0;          ///< by this machine's clock; does not decrease
  };

  /// @param same_clock  The presentation times are by this machine's clock (a camera of this
  /// machine): they are the stamps.
  explicit StreamClock(bool same_clock = false) : same_clock_(same_clock) {}

  /// True when the presentation times begin anew with this frame, although Restart() was not
  /// called: it is not later than the frame before.
  [[nodiscard]] bool Breaks(const Times& frame) const;
  /// The next frames have another zero: the source was opened again.
  void Restart();
  /// A frame arrived; frames in the order of the stream, also those that are dropped afterwards.
  void Arrive(const Times& frame);

  /// Senders begin with a burst of frames that are older than they appear. True when the burst is
  /// over: a frame was waited for, two frames had no presentation time, or 0.25 s have passed.
  [[nodiscard]] bool Settled(double now_s) const;
  /// The stamp of a frame that has arrived since the last Restart(); each at most once, in order.
  /// A frame without presentation time in a stream that has them is a median interval from the
  /// frames beside it.
  double Stamp(const Times& frame);

  /// Frames that are missing between those that arrived, by gaps between their presentation times
  /// of at least 1.5 median intervals of the last 31; unset without presentation times.
  [[nodiscard]] std::optional<std::int64_t> Missing() const { return missing_; }

 private:
  void MoveZero(double delay_s, double arrival_s);
  void CountMissing(const Times& frame);
  [[nodiscard]] double Target(const Times& frame) const;
  [[nodiscard]] double Mapped(double time_s) const;

  bool same_clock_;
  // Since Restart:
  std::optional<Times> first_;  // with a presentation time
  std::optional<Times> last_;   // with a presentation time
  int without_time_ = 0;
  std::optional<double> began_s_;
  bool settled_ = false;
  // Smallest arrival minus presentation time of this and of the last period of 5 s.
  double period_began_s_ = 0;
  std::optional<double> smallest_s_;
  std::optional<double> smallest_before_s_;

  std::optional<double> last_stamp_s_;
  std::optional<double> last_stamped_s_;  // its presentation time, since Restart
  std::deque<double> intervals_s_;
  std::optional<std::int64_t> missing_;
};

}  // namespace ceilmap::recordings
