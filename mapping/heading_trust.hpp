#pragma once

#include "calib/base/heading.hpp"

namespace ceilmap::mapping {

/// How far a compass is believed. The ceiling tells rotations a hundred times more exactly, but
/// under square tiles not by which quarter: that is what the compass is asked.
struct HeadingTrust {
  double noise_rad = kHeadingNoise;  ///< what a single heading is off at the least, > 0
  /// A rotation contradicts the compass when it is further off than this many standard deviations
  /// of the difference, > 0, ...
  double max_sigmas = 5;
  /// ... and than this, > 0: a regular ceiling fits again after a sixth of a turn at the soonest. A
  /// smaller difference is the compass' own (people walking past), not another orientation.
  double min_rad = 0.26;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// Is a turn that is known otherwise another orientation than the compass says?
bool Contradict(const HeadingTurn& compass, const HeadingTurn& other, const HeadingTrust& trust);

}  // namespace ceilmap::mapping
