#pragma once

#include <chrono>

namespace ceilmap::terminal {

/// Seconds since 1970 by this machine's clock, for the frames of live sources.
inline double ClockSeconds() {
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration<double>(since_1970).count();
}

/// Seconds by the steady clock, CLOCK_MONOTONIC: its zero is arbitrary, and it is never set.
inline double SteadySeconds() {
  const auto since_zero = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(since_zero).count();
}

/// Elapsed time, independent of changes of the clock.
inline double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}
inline double MillisecondsSince(std::chrono::steady_clock::time_point start) {
  return 1e3 * SecondsSince(start);
}

}  // namespace ceilmap::terminal
