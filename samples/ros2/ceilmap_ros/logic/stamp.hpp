#pragma once

#include <cstdint>
#include <optional>

namespace ceilmap_ros {

/// A time of the ROS clock, nanoseconds: as exact as message headers, where a double is not.
using Stamp = std::int64_t;

constexpr Stamp kSecond = 1'000'000'000;

constexpr double ToSeconds(Stamp duration) {
  return 1e-9 * static_cast<double>(duration);
}
constexpr Stamp FromSeconds(double seconds) {
  return static_cast<Stamp>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5));
}

/// A stream whose stamp is this far before its last one was started again with its clock: a bag
/// that is played in a loop, a simulation that was reset. A smaller step back is a message that
/// came out of order.
constexpr Stamp kClockReset = kSecond;

/// The order of the stamps of one stream.
class StreamOrder {
 public:
  enum class Step { kNext, kOutOfOrder, kReset };

  /// Takes the stamp as the last one, unless it is out of order.
  Step Take(Stamp stamp) {
    if (last_ && stamp <= *last_ - kClockReset) {
      last_ = stamp;
      return Step::kReset;
    }
    if (last_ && stamp <= *last_) return Step::kOutOfOrder;
    last_ = stamp;
    return Step::kNext;
  }
  void Forget() { last_.reset(); }
  [[nodiscard]] std::optional<Stamp> Last() const { return last_; }

 private:
  std::optional<Stamp> last_;
};

/// The seconds that the libraries are given. They never decrease, whatever the ROS clock does, and
/// are small, so that a double holds them exactly enough.
class Timeline {
 public:
  /// Begins again at a stamp of a clock that was reset: `kGapS` later than all times before.
  void Restart(Stamp stamp) {
    start_s_ = begun_ ? latest_s_ + kGapS : 0;
    origin_ = stamp;
    latest_s_ = start_s_;
    begun_ = true;
  }
  /// The first stamp is the origin.
  double At(Stamp stamp) {
    if (!begun_) Restart(stamp);
    const double at_s = start_s_ + ToSeconds(stamp - origin_);
    if (at_s > latest_s_) latest_s_ = at_s;
    return at_s;
  }

 private:
  static constexpr double kGapS = 10;
  bool begun_ = false;
  Stamp origin_ = 0;
  double start_s_ = 0;
  double latest_s_ = 0;
};

}  // namespace ceilmap_ros
