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

/// The minimum between the columns.
struct SubPixelMinimum {
  double shift = 0;     ///< columns from the middle one, in [-1/2, 1/2]
  double distance = 0;  ///< there, at most the least of the three
};

/// The minimum of a parabola through the three distances (alpha tilde and d tilde in Labrosse
/// 2006), which is correct where the minimum is round: when the panoramas differ (other objects in
/// view, noise). The middle column where all three distances are equal.
SubPixelMinimum ParabolicMinimum(const ShiftNeighbours& distances);
/// The same from two lines of opposite slope (alpha hat and d hat): one through the least distance
/// and the largest of the three, one through the third. Correct where the minimum is a sharp V:
/// when the panoramas agree, because the distance then grows in proportion to the shift. Rounding
/// can make its distance negative where the least is nearly 0.
SubPixelMinimum LinearMinimum(const ShiftNeighbours& distances);
/// p times the linear minimum and 1 - p times the parabolic one: Labrosse 2006, Eq. 10 and 11.
/// @param p  LinearPart, or any other number in [0, 1].
SubPixelMinimum BlendedMinimum(const ShiftNeighbours& distances, double p);
/// p of Eq. 10 and 11: 0 up to a normalised amplitude of 1/2, then it rises to 1 at 1 and stays
/// there, where the paper says nothing.
double LinearPart(double normalized_amplitude);

/// Relative depth of a minimum: (largest - least) / largest, in [0, 1]; 0 if there are no
/// distances, or if all are 0. Not the amplitude of the paper, which is Labrosse2006's own.
double RelativeDepth(std::span<const double> distances);

/// Variance of the shift of least squared distance, columns^2: 2 S0 / (N S''), with S0 the squared
/// distance at the minimum and S'' its curvature there. This is the least-squares variance for N
/// independent columns. Neighbouring pixels show the same content, so their differences count as
/// one error, not many.
/// @param independent_columns  N, > 0.
/// @return infinity where the three distances are equal.
double ShiftVariance(const ShiftNeighbours& distances, double independent_columns);

}  // namespace ceilmap::labrosse
