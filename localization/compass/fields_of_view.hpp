#pragma once

#include <numbers>
#include <vector>

namespace ceilmap::compass {

/// The parts of a panorama that a compass looks at. Travel moves what stands at the sides of a
/// robot along the panorama, as a turn would; ahead of it and behind it content only grows or
/// shrinks, so heading is read there (Labrosse 2006).
struct FieldsOfView {
  /// Middles of the fields, rad, seen from the robot, counter-clockwise from its front; any finite
  /// angle.
  std::vector<double> centres_rad{0, std::numbers::pi};
  double width_rad = std::numbers::pi / 3;  ///< of each field, in (0, 2 pi]; 2 pi: the whole view

  /// Two fields, towards the direction of travel and away from it, which so move with it.
  static FieldsOfView FrontAndBack(double travel_direction_rad, double width_rad);

  /// @throws InputError on a field outside its range, or no centre.
  void Validate() const;

  /// What each column of a panorama counts: 1 where the azimuth of the column's middle, 2 pi (W/2 -
  /// u) / W, is at most half a width away from a centre, edges included (so 60 deg about a column
  /// are 61 columns of 360, as many to the left as to the right), 0 elsewhere.
  /// A field between two columns, narrower than one, holds none.
  /// @param columns  W, > 0.
  /// @return W weights, in [0, 1].
  [[nodiscard]] std::vector<float> ColumnWeights(int columns) const;
};

}  // namespace ceilmap::compass
