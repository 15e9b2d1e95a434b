#pragma once

#include <algorithm>
#include <cmath>

namespace ceilmap::compensation {

/// Value and derivative of a function of one variable at one argument.
struct ValueAndSlope {
  double value;
  double slope;
};

/// The root of `function` between `low` and `high`, to 1e-15. Newton's method with bisection: a
/// step that leaves the bracket or does not shrink fast enough is replaced by halving the bracket,
/// so the search never diverges.
///
/// @param function  Callable as ValueAndSlope(double); continuous, of opposite signs (or zero) at
///   the two ends, finite between them. If there are several roots, one of them is returned.
/// @param low, high  The bracket, low <= high.
/// @param start  Initial value, in [low, high].
template <typename Function>
double BracketedRoot(const Function& function, double low, double high, double start) {
  constexpr double kResolution = 1e-15;
  constexpr int kMaxSteps = 200;  // each step halves the bracket or the step: 110 steps reach 1e-15
  const bool rising = function(low).value < 0 || function(high).value > 0;
  double x = start;
  double last_step = high - low;
  for (int i = 0; i < kMaxSteps; ++i) {
    const ValueAndSlope at_x = function(x);
    if (at_x.value == 0) break;
    ((at_x.value > 0) == rising ? high : low) = x;
    double next = x - at_x.value / at_x.slope;
    if (!(next > low && next < high && std::abs(next - x) <= 0.5 * last_step)) {
      next = low + 0.5 * (high - low);
    }
    last_step = std::abs(next - x);
    x = next;
    if (last_step <= kResolution) break;
  }
  return x;
}

}  // namespace ceilmap::compensation
