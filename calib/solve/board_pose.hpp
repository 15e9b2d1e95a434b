#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"
#include "calib/solve/lens.hpp"

namespace ceilmap::calibration {

/// The board's corners that a view shows.
std::vector<cv::Point3d> BoardPoints(const Board& board, const BoardView& view);

/// The pose that fits a view best, for a lens that is known. Nothing when there is none.
std::optional<BoardPose> FindPose(const Lens& lens, const Board& board, const BoardView& view);

}  // namespace ceilmap::calibration
