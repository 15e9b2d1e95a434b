#pragma once

#include <span>

#include "localization/compass/sector_shifts.hpp"

namespace ceilmap::compass {

struct ParallaxParams {
  /// The surroundings' nearness around the circle is a Fourier series of this order, [0, 12] ...
  int order = 5;
  /// ... whose terms of order k are expected to be this part / k of the mean, > 0.
  double roughness = 0.5;
  /// Standard deviation of the direction of travel that is expected, rad, > 0.
  double direction_sigma_rad = 0.105;
  /// What a sector's shift is off by beyond its own noise, rad, > 0: in any case, and per shift
  /// that travel causes in the mean (things at several distances in one direction).
  double floor_rad = 0.0014;
  double floor_ratio = 0.055;
  /// Residuals beyond this many standard deviations count less and less, > 0.
  double robust_sigmas = 2;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// Turn and travel that explain the shifts of the sectors.
struct ParallaxFit {
  double rotation_rad = 0;  ///< counter-clockwise, near the sectors' shifts; not wrapped
  double variance_rad2 = 0;
  /// Direction of travel (or its opposite) as seen from the current place, rad.
  double direction_rad = 0;
  /// Mean shift that travel causes at the sides, rad: way / distance of what stands around; its
  /// sign tells nothing.
  double parallax_rad = 0;
  /// Part of the sectors asked for that tell a shift and agree with the fit, 0..1.
  double inlier_ratio = 0;
  /// Minus twice the log of its likelihood, prior included, up to a constant: fits of the same
  /// shifts can be compared.
  double cost = 0;
};

/// Separates turn and travel. A robot that turns by w and travels in direction d sees what stands
/// at azimuth a and distance R move by
///
///     shift(a) = w + (way / R(a)) sin(a - d)
///
/// (GEOMETRY section 5; exact to first order in way / R). Ahead and behind, where the sine is zero,
/// only w is left: that is why Labrosse looks there. Here all directions count: the nearness
/// way / R(a) is a smooth function around the circle, and is estimated together with w and d by
/// robust least squares (Gauss-Newton, Cauchy weights), with the prior that nearness varies the
/// less the finer the detail. Things that move by themselves are outliers.
///
/// @param sectors_asked  how many sectors there are in all. @param expected_direction_rad  of
/// travel, from the current place. Microseconds.
/// @return variance infinite and inlier part 0 when fewer than 6 sectors tell a shift.
ParallaxFit FitParallax(std::span<const SectorShift> shifts,
                        int sectors_asked,
                        double expected_direction_rad,
                        const ParallaxParams& params = {});

/// The same where nothing is known of the direction, as between two visits of a place: fits for
/// directions all around, each as likely as its cost says. Four times the work.
/// @return the likeliest one, with the mean of all as its rotation; what they disagree by is in
/// the variance.
ParallaxFit FitParallaxOfAnyDirection(std::span<const SectorShift> shifts,
                                      int sectors_asked,
                                      const ParallaxParams& params = {});

}  // namespace ceilmap::compass
