#pragma once

namespace ceilmap::compensation {

/// A motion that goes on at an even speed: how many steps like the last one, from `before_s` to
/// `last_s`, lie between `last_s` and `now_s`. 0 after a gap: of three steps the speed is not known
/// any more.
inline double StepsAhead(double before_s, double last_s, double now_s) {
  constexpr double kMax = 3;
  const double steps = (now_s - last_s) / (last_s - before_s);
  return steps > 0 && steps <= kMax ? steps : 0;
}

}  // namespace ceilmap::compensation
