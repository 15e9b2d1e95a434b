#pragma once

#include <complex>
#include <span>

/// How two images lie to each other, from windows that look alike. Internal.
namespace ceilmap::places {

/// A window's place in an image, x + iy: x right, y down from the centre, in lengths of
/// units_per_px (PlaceDescriber).
using ImagePoint = std::complex<float>;

/// Where a window of the query lies, and the stored window that resembles it.
struct PlacePair {
  ImagePoint query;
  ImagePoint stored;
  float weight = 0;  ///< how much the two look alike, > 0; comparable within one query
};

/// p_stored = turn * p_query + shift.
struct PlaceMotion {
  ImagePoint turn{1, 0};  ///< length 1; its argument is clockwise on the screen
  ImagePoint shift;
};

struct PlaceFit {
  float weight = 0;  ///< of the pairs that agree with the motion, summed
  int pairs = 0;     ///< their number: 0, or at least 2
  PlaceMotion motion;
};

/// The rotation and shift under which most weight of the pairs agrees: every two pairs propose one,
/// all others are held against it, and those that agree with the best refine it by weighted least
/// squares. The work grows with the cube of the number of pairs; the same pairs in the same order
/// give the same answer.
///
/// @param tolerance  of a window's place, units of ImagePoint, > 0. Pairs less than three of it
/// apart propose nothing, nor do those that are not equally far apart in both images.
/// @return no pairs, no weight and the identity when no two pairs define a motion.
PlaceFit BestFit(std::span<const PlacePair> pairs, float tolerance);

}  // namespace ceilmap::places
