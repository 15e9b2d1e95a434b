#pragma once

#include <complex>
#include <span>

/// Motion between two images, from pairs of similar windows. Internal.
namespace ceilmap::places {

/// Position of a window in an image, x + iy: x right, y down from the centre, in lengths of
/// units_per_px (PlaceDescriber).
using ImagePoint = std::complex<float>;

/// Position of a window of the query, and the similar stored window.
struct PlacePair {
  ImagePoint query;
  ImagePoint stored;
  float weight = 0;  ///< similarity of the two, > 0; comparable within one query
};

/// p_stored = turn * p_query + shift.
struct PlaceMotion {
  ImagePoint turn{1, 0};  ///< length 1; its argument is clockwise on the screen
  ImagePoint shift;
};

struct PlaceFit {
  float weight = 0;  ///< sum over the pairs that agree with the motion
  int pairs = 0;     ///< their number: 0, or at least 2
  PlaceMotion motion;
};

/// The rotation and shift with the largest weight of agreeing pairs: every two pairs propose one,
/// all others are tested against it, and the best one is refined from the agreeing pairs by
/// weighted least squares. The cost is cubic in the number of pairs; the result is deterministic.
///
/// @param tolerance  Of a window's position, units of ImagePoint, > 0. Pairs at less than three
/// times this distance, or with different distances in the two images, propose no motion.
/// @return no pairs, no weight and the identity when no two pairs define a motion.
PlaceFit BestFit(std::span<const PlacePair> pairs, float tolerance);

}  // namespace ceilmap::places
