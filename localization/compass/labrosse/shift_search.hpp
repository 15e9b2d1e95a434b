#pragma once

#include <functional>
#include <numbers>

#include "localization/compass/labrosse/shift_minimum.hpp"

namespace ceilmap::labrosse {

/// Angle from the first probe to the last, rad: up to 10 deg to either side.
inline constexpr double kProbeSpanRad = std::numbers::pi / 9;

struct FoundShift {
  int columns = 0;  ///< not wrapped: near the start of the search
  ShiftNeighbours distances;
  /// RelativeDepth of the minimum, its two neighbours and the probes around it. It depends only on
  /// the panoramas, not on the start of the search.
  double depth = 0;
};

/// Labrosse 2006, section 3.3.4: descent from `start` in steps of a column; then eight probes over
/// 20 deg, centred on the minimum found and evenly spaced; descent again from the lowest probe if
/// it is lower; repeated until no probe is lower.
///
/// @param distance  Distance of the panoramas at a shift, >= 0; called at most once for each shift
///   in 0 .. columns - 1.
/// @param columns  Width of the panoramas, >= 2.
/// @param probe_span_rad  Angle from the first probe to the last, in (0, 2 pi).
FoundShift FindShift(const std::function<double(int)>& distance,
                     int columns,
                     int start,
                     double probe_span_rad = kProbeSpanRad);

}  // namespace ceilmap::labrosse
