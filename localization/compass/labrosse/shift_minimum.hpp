#pragma once

#include <span>

namespace ceilmap::labrosse {

/// Distances of two panoramas (square roots, not squared) at the shift where they are least, and
/// one column to either side of it: left >= least <= right, all >= 0.
struct ShiftNeighbours {
  double left = 0;   ///< one column less
  double least = 0;  ///< at the minimum
  double right = 0;  ///< one column more
};

/// Position of the minimum between the columns, in columns from the middle one, in [-1/2, 1/2]; 0
/// where all three distances are equal. From a parabola through the three distances, which is
/// correct where the minimum is round: when the panoramas differ (other objects in view, noise).
double ParabolaMinimum(const ShiftNeighbours& distances);
/// The same from two lines of opposite slope through the three distances, which is correct where
/// the minimum is a sharp V: when the panoramas agree, because the distance then grows in
/// proportion to the shift.
double VMinimum(const ShiftNeighbours& distances);
/// The same from a blend of both: amplitude V + (1 - amplitude) parabola, Labrosse 2006, Eq. 7-12.
/// These equations are reconstructed from their description, not copied from the paper's text.
/// @param amplitude  NormalizedAmplitude, in [0, 1].
double BlendedMinimum(const ShiftNeighbours& distances, double amplitude);

/// Relative depth of the minimum: (largest - least) / largest, in [0, 1]; 0 if there are no
/// distances, or if all are 0.
double NormalizedAmplitude(std::span<const double> distances);

/// Variance of the shift of least squared distance, columns^2: 2 S0 / (N S''), with S0 the squared
/// distance at the minimum and S'' its curvature there. This is the least-squares variance for N
/// independent columns. Neighbouring pixels show the same content, so their differences count as
/// one error, not many.
/// @param independent_columns  N, > 0.
/// @return infinity where the three distances are equal.
double ShiftVariance(const ShiftNeighbours& distances, double independent_columns);

}  // namespace ceilmap::labrosse
