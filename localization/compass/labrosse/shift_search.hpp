#pragma once

#include <functional>
#include <numbers>

#include "localization/compass/labrosse/shift_minimum.hpp"

namespace ceilmap::labrosse {

struct ShiftSearchParams {
  /// Shifts that are tried around a minimum, even, >= 2, half of them to either side.
  int probes = 8;
  /// From the first probe to the last, rad, in (0, 2 pi): 20 deg, i.e. up to 10 deg to either side.
  double probe_span_rad = std::numbers::pi / 9;

  void Validate() const;  ///< throws InputError naming field, value and range
};

struct FoundShift {
  int columns = 0;  ///< not wrapped: near the start
  ShiftNeighbours distances;
  /// NormalizedAmplitude of the minimum, its two neighbours and the probes around it: it depends
  /// on the panoramas alone, not on where the search began.
  double amplitude = 0;
};

/// Labrosse 2006, Algorithm 1: downhill from `start` in steps of a column; then the probes, evenly
/// spread around the minimum found; downhill again from the lowest of them if that is lower; until
/// none is.
///
/// The paper's "8 probes over 20 deg" is read as 20 deg in total. With 20 deg to either side the
/// amplitude is larger, references stay longer than the threshold was meant for, and the drift on
/// a recorded circle is more than twice as large.
///
/// @param distance  Of the panoramas at a shift, >= 0; called at most once for a shift in 0 ..
///   columns - 1.
/// @param columns  Of the panoramas, >= 2.
FoundShift FindShift(const std::function<double(int)>& distance,
                     int columns,
                     int start,
                     const ShiftSearchParams& params = {});

}  // namespace ceilmap::labrosse
