#pragma once

#include <span>

#include "localization/compass/sector_shifts.hpp"

namespace ceilmap::compass {

/// Turn and travel that explain the shifts of the sectors.
struct ParallaxFit {
  double rotation_rad = 0;  ///< counter-clockwise, near the sectors' shifts; not wrapped
  double variance_rad2 = 0;
  /// Direction of travel (or its opposite), seen from the current place, rad.
  double direction_rad = 0;
  /// Mean shift that travel causes at the sides, rad: distance travelled / distance of the
  /// surroundings. Its sign has no meaning.
  double parallax_rad = 0;
  /// Fraction of the requested sectors that have a valid shift and agree with the fit, 0..1.
  double inlier_ratio = 0;
  /// Minus twice the log likelihood, prior included, up to a constant. It allows the comparison of
  /// fits to the same shifts.
  double cost = 0;
};

/// Separates turn and travel. For a robot that turns by w and travels a distance t in direction d,
/// the content at azimuth a and distance R moves by
///
///     shift(a) = w + (t / R(a)) sin(a - d)
///
/// (localization/compass/README.md; exact to first order in t / R). Ahead and behind, where the
/// sine is zero, only w remains; for this reason Labrosse measures there. Here all directions are
/// used: the nearness t / R(a) is a smooth function around the circle and is estimated together
/// with w and d by robust least squares (Gauss-Newton, Cauchy weights). The prior expects smaller
/// variations of nearness at finer angular scales. Objects that move independently are outliers.
///
/// @param sectors_asked  Total number of sectors.
/// @param expected_direction_rad  Direction of travel, seen from the current place.
/// @return infinite variance and inlier ratio 0 when fewer than 6 sectors have a valid shift. Takes
///   microseconds.
ParallaxFit FitParallax(std::span<const SectorShift> shifts,
                        int sectors_asked,
                        double expected_direction_rad);

/// The same fit where nothing is known about the direction, as between two visits of a place: fits
/// for directions all around, each weighted by the likelihood that follows from its cost. Costs
/// four times as much.
/// @return the most likely fit, with the weighted mean of all as its rotation; the variance
///   includes their disagreement.
ParallaxFit FitParallaxOfAnyDirection(std::span<const SectorShift> shifts, int sectors_asked);

}  // namespace ceilmap::compass
