#pragma once

#include <numbers>
#include <vector>

namespace ceilmap::compass {

/// The parts of a panorama that a compass evaluates. Travel moves the content at the sides of a
/// robot along the panorama, as a turn would. Ahead and behind, content only grows or shrinks, so
/// heading is measured there (Labrosse 2006).
struct FieldsOfView {
  /// Centres of the fields, rad, seen from the robot, counter-clockwise from its front; any finite
  /// angle.
  std::vector<double> centres_rad{0, std::numbers::pi};
  double width_rad = std::numbers::pi / 3;  ///< of each field, in (0, 2 pi]; 2 pi: the whole view

  /// Two fields, in the direction of travel and opposite to it; they rotate with that direction.
  static FieldsOfView FrontAndBack(double travel_direction_rad, double width_rad);

  /// @throws InputError on a field outside its range, or no centre.
  void Validate() const;

  /// Weight of each column of a panorama: 1 where the azimuth of the column's centre, 2 pi (W/2 -
  /// u) / W, is at most half a width away from a centre, edges included (60 deg around a column are
  /// 61 columns of 360, as many to the left as to the right); 0 elsewhere. A field that is narrower
  /// than a column and lies between two columns contains none.
  /// @param columns  W, > 0.
  /// @return W weights, in [0, 1].
  [[nodiscard]] std::vector<float> ColumnWeights(int columns) const;
};

}  // namespace ceilmap::compass
