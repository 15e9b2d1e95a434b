#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"
#include "calib/solve/board_projection.hpp"

namespace ceilmap::calibration {

/// The board's corners in a view.
std::vector<cv::Point3d> BoardPoints(const Board& board, const BoardView& view);

/// The pose that fits a view best, for a known lens. Nothing when there is none.
std::optional<BoardPose> FindPose(const Lens& lens, const Board& board, const BoardView& view);

}  // namespace ceilmap::calibration
