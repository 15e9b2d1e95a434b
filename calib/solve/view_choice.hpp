#pragma once

#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"
#include "calib/solve/lens.hpp"

namespace ceilmap::calibration {

/// Chooses the views of a recording that tell most of the lens.
///
/// A first calibration from views that differ much in place, size and slant gives a lens and, with
/// it, the information of every view. Views are then taken one by one, each the one that adds most
/// to the logarithm of the information's determinant (D-optimal design): places in the image,
/// tilts and distances that are not there yet. Blurred views count less, by their edges' width. The
/// same views give the same choice.
///
/// @param most  at least 3. @return indices, rising; all of them when there are no more than
/// `most`.
std::vector<std::size_t> ChooseViews(const Board& board,
                                     const std::vector<BoardView>& views,
                                     cv::Size size,
                                     LensModel model,
                                     std::size_t most);

}  // namespace ceilmap::calibration
