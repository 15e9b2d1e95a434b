#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "localization/compass/colour/colour_model.hpp"

namespace ceilmap::colour {

/// Maps the direction in which an object is observed from a place near a cell to its direction from
/// the cell. All objects are assumed to lie on a cylinder around the cell.
class DirectionTable {
 public:
  static constexpr int kSteps = 720;  ///< directions around the circle, half a degree each

  /// @param offset  Offset of the place from the cell, as a ratio of the cylinder's radius, shorter
  ///   than 1.
  /// @param bins  Number of bins of the cell.
  DirectionTable(const Eigen::Vector2d& offset, int bins);

  /// Position among the centres of bins: between bin `lower` and the next one counter-clockwise, at
  /// the fraction `fraction` of the interval.
  struct Entry {
    std::int16_t lower = 0;
    std::int16_t upper = 0;
    float fraction = 0;
  };
  [[nodiscard]] const Entry& At(int step) const { return entries_[static_cast<std::size_t>(step)]; }

 private:
  std::vector<Entry> entries_;
};

/// A possible place of a robot whose position is not known.
struct Place {
  Eigen::Vector2d at;
  int cell = 0;  ///< the cell it is compared with: the nearest one that is not empty
  DirectionTable directions;
  std::array<int, 4> neighbours{-1, -1, -1, -1};  ///< on the grid of places; -1: none
};

/// The cell of a model nearest to a place that is not empty; the position of a cell is the mean of
/// the positions learned in it. @return -1 when all cells are empty.
int NearestLearned(const ColourModel& model, const Eigen::Vector2d& place);

/// Offset of a place from a learned cell, as a ratio of the depth of the model, no longer than
/// `most`.
Eigen::Vector2d OffsetFrom(const ColourModel& model,
                           int cell,
                           const Eigen::Vector2d& place,
                           double most);

/// Places around all learned cells, on a square grid.
/// @param reach  Largest distance from a cell, as a ratio of the depth; 0: only the cells' own
///   places.
/// @param spacing  Spacing of the grid, as a ratio of the depth.
std::vector<Place> PlacesAround(const ColourModel& model, double reach, double spacing);

}  // namespace ceilmap::colour
