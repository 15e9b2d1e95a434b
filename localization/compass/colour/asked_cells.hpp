#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "localization/compass/colour/colour_model.hpp"
#include "localization/compass/colour/colour_query.hpp"

namespace ceilmap::colour {

/// A cell of which a frame is asked.
struct AskedCell {
  int cell = 0;
  double share = 1;       ///< of the weight of all position hypotheses, (0, 1]
  Eigen::Vector2d place;  ///< weighted mean of the hypotheses in it
};

/// The rule of Methenitis et al. 2013: "orientations are computed for grid cells containing at
/// least 20% of the hypotheses".
///
/// Left open by the paper, and filled here: a hypothesis in a cell that has learned nothing counts
/// for the nearest cell that has; if no cell reaches the ratio (six cells with a sixth each), those
/// with the most weight are asked.
///
/// @param model  Not empty.
/// @param places  At least one.
/// @param min_share  Ratio of the weights, [0, 1].
/// @return at least one cell, by falling share; equal ones by rising number.
/// @throws InputError on a weight that is not > 0, or a position that is not finite.
std::vector<AskedCell> AskedCells(const ColourModel& model,
                                  std::span<const PlaceHypothesis> places,
                                  double min_share);

}  // namespace ceilmap::colour
