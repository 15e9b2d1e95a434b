#pragma once

#include "calib/base/heading.hpp"

namespace ceilmap::mapping {

/// Limits for the use of a compass. The ceiling measures rotations about a hundred times more
/// accurately. On square tiles, however, it leaves the quarter turn open; the compass resolves it.
struct HeadingTrust {
  double noise_rad = kHeadingNoise;  ///< smallest standard deviation of a single heading, > 0
  /// A rotation contradicts the compass when their difference exceeds both this number of standard
  /// deviations of the difference, > 0, ...
  double max_sigmas = 5;
  /// ... and this angle, > 0. The smallest rotation by which a regular ceiling matches itself is a
  /// sixth of a turn. A smaller difference is an error of the compass (people walking past), not
  /// another orientation.
  double min_rad = 0.26;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Whether a turn from another source is a different orientation from the one that the compass
/// measured.
bool Contradict(const HeadingTurn& compass, const HeadingTurn& other, const HeadingTrust& trust);

}  // namespace ceilmap::mapping
