#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "localization/compass/colour/colour_model.hpp"

namespace ceilmap::colour {

/// In which direction from the cell a thing stands that is seen in some direction from a place near
/// it. All things stand on a cylinder about the cell.
class DirectionTable {
 public:
  static constexpr int kSteps = 720;  ///< directions around, half a degree each

  /// @param offset  of the place from the cell, as a part of the cylinder's radius, shorter than 1.
  /// @param bins  of the cell.
  DirectionTable(const Eigen::Vector2d& offset, int bins);

  /// Position among the middles of bins: between bin `lower` and the next one around, `part` of the
  /// way.
  struct Entry {
    std::int16_t lower = 0;
    std::int16_t upper = 0;
    float part = 0;
  };
  [[nodiscard]] const Entry& At(int step) const { return entries_[static_cast<std::size_t>(step)]; }

 private:
  std::vector<Entry> entries_;
};

/// A place where a robot may be whose place is not known.
struct Place {
  Eigen::Vector2d at;
  int cell = 0;  ///< that it is compared with: the nearest one that has something
  DirectionTable directions;
  std::array<int, 4> neighbours{-1, -1, -1, -1};  ///< on the grid of places; -1: none
};

/// Cell of a model that is nearest to a place and has something; its place is the mean of what was
/// learned in it. @return -1 when all are empty.
int NearestLearned(const ColourModel& model, const Eigen::Vector2d& place);

/// From a learned cell to a place, as a part of the depth of the model, no longer than `most`.
Eigen::Vector2d OffsetFrom(const ColourModel& model,
                           int cell,
                           const Eigen::Vector2d& place,
                           double most);

/// Places around all learned cells, on a square grid.
/// @param reach  from a cell, as a part of the depth; 0: the cells' own places alone.
/// @param spacing  of the grid, the same.
std::vector<Place> PlacesAround(const ColourModel& model, double reach, double spacing);

}  // namespace ceilmap::colour
