#pragma once

namespace ceilmap::calib {

/// A measured heading. Counter-clockwise seen from above; which direction is 0 is up to whoever
/// made the samples.
struct HeadingSample {
  double stamp_s = 0;
  double heading_rad = 0;  ///< any finite angle
  double sigma_rad = 0;    ///< standard deviation, > 0
};

/// What is known of the heading at some moment, as a prior for registration, mapping, tracking or
/// search. Headings of one source are relative to one unknown direction, from which they drift.
struct HeadingPrior {
  double heading_rad = 0;    ///< in (-pi, pi]
  double variance_rad2 = 0;  ///< > 0
};

}  // namespace ceilmap::calib
