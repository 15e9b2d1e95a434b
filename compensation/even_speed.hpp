#pragma once

namespace ceilmap::compensation {

/// Extrapolation factor of the constant-velocity model: `now_s` - `last_s` in units of the last
/// step, from `before_s` to `last_s`. 0 after a gap: beyond three steps the velocity is taken as
/// unknown.
inline double StepsAhead(double before_s, double last_s, double now_s) {
  constexpr double kMax = 3;
  const double steps = (now_s - last_s) / (last_s - before_s);
  return steps > 0 && steps <= kMax ? steps : 0;
}

}  // namespace ceilmap::compensation
