#pragma once

#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"
#include "calib/solve/board_projection.hpp"

namespace ceilmap::calibration {

/// Selects the most informative views of a recording for a lens calibration.
///
/// A first calibration from views of very different position, size and slant gives a lens and the
/// information of every view. Then the view that increases the logarithm of the determinant of the
/// information most is added, one by one (D-optimal design): with new positions in the image, tilts
/// and distances. Blurred views have less weight, by the width of their edges. The result is
/// deterministic.
///
/// @param most  At least 3. @return indices, increasing; all of them when there are no more than
/// `most`.
std::vector<std::size_t> ChooseViews(const Board& board,
                                     const std::vector<BoardView>& views,
                                     cv::Size size,
                                     LensModel model,
                                     std::size_t most);

}  // namespace ceilmap::calibration
