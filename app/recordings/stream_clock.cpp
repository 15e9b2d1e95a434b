#include "app/recordings/stream_clock.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/base/statistics.hpp"

namespace ceilmap::recordings {
namespace {

constexpr double kSettleS = 0.25;

}  // namespace

bool StreamClock::Breaks(const Times& frame) const {
  return last_ && frame.time_s && *frame.time_s <= *last_->time_s;
}

void StreamClock::Restart() {
  first_.reset();
  last_.reset();
  without_time_ = 0;
  began_s_.reset();
  settled_ = false;
  smallest_s_.reset();
  smallest_before_s_.reset();
  last_stamped_s_.reset();
}

void StreamClock::Arrive(const Times& frame) {
  if (!began_s_) began_s_ = frame.arrival_s;
  if (!frame.time_s) {
    if (!first_ && ++without_time_ > 1) settled_ = true;
    return;
  }
  if (same_clock_) settled_ = true;
  if (!first_) first_ = frame;
  if (last_) {
    const double interval_s = *frame.time_s - *last_->time_s;
    if (frame.arrival_s - last_->arrival_s >= 0.5 * interval_s) settled_ = true;
  }
  MoveZero(frame.arrival_s - *frame.time_s, frame.arrival_s);
  CountMissing(frame);
  last_ = frame;
}

void StreamClock::MoveZero(double delay_s, double arrival_s) {
  constexpr double kPeriodS = 5;
  if (!smallest_s_ || arrival_s - period_began_s_ > kPeriodS) {
    smallest_before_s_ = smallest_s_;
    smallest_s_ = delay_s;
    period_began_s_ = arrival_s;
  }
  smallest_s_ = std::min(*smallest_s_, delay_s);
}

void StreamClock::CountMissing(const Times& frame) {
  constexpr std::size_t kIntervals = 31;
  constexpr std::size_t kMinIntervals = 5;
  if (!missing_) missing_ = 0;
  if (!last_) return;
  const double steps = static_cast<double>(frame.index - last_->index);
  const double interval_s = *frame.time_s - *last_->time_s;
  if (intervals_s_.size() >= kMinIntervals) {
    const double period_s = Median({intervals_s_.begin(), intervals_s_.end()});
    if (interval_s >= (steps + 0.5) * period_s) {
      *missing_ += std::llround(interval_s / period_s - steps);
    }
  }
  intervals_s_.push_back(interval_s / std::max(steps, 1.0));
  if (intervals_s_.size() > kIntervals) intervals_s_.pop_front();
}

bool StreamClock::Settled(double now_s) const {
  return settled_ || !began_s_ || now_s - *began_s_ >= kSettleS;
}

double StreamClock::Mapped(double time_s) const {
  if (same_clock_) return time_s;
  return time_s + std::min(*smallest_s_, smallest_before_s_.value_or(*smallest_s_));
}

double StreamClock::Target(const Times& frame) const {
  if (frame.time_s) return Mapped(*frame.time_s);
  if (!first_ || intervals_s_.empty()) return frame.arrival_s;
  const double period_s = Median({intervals_s_.begin(), intervals_s_.end()});
  const auto before_first = static_cast<double>(first_->index - frame.index);
  if (before_first > 0) return Mapped(*first_->time_s) - before_first * period_s;
  return *last_stamp_s_ + period_s;
}

double StreamClock::Stamp(const Times& frame) {
  constexpr double kMinS = 1e-3;
  double stamp_s = Target(frame);
  if (last_stamp_s_ && frame.time_s && last_stamped_s_) {
    const double interval_s = *frame.time_s - *last_stamped_s_;
    stamp_s =
        std::clamp(stamp_s, *last_stamp_s_ + 0.5 * interval_s, *last_stamp_s_ + 1.5 * interval_s);
  }
  if (last_stamp_s_ && stamp_s <= *last_stamp_s_) stamp_s = *last_stamp_s_ + kMinS;
  last_stamp_s_ = stamp_s;
  last_stamped_s_ = frame.time_s;
  return stamp_s;
}

}  // namespace ceilmap::recordings
