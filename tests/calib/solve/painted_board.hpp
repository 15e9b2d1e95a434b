#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_projection.hpp"

namespace ceilmap::calibration {

/// Paints the image of a printed board: rays through parts of every pixel, averaged.
class BoardPainter {
 public:
  /// @param lens  valid in every pixel.
  BoardPainter(const Board& board, const Lens& lens);

  /// @param pose  of the drawn board: origin at its upper left corner where four squares meet, x to
  ///   the right and y down on the sheet, z into it. @return CV_8UC1 on a dark, uneven background.
  [[nodiscard]] cv::Mat Paint(const BoardPose& pose) const;

  /// Where the corners are, row by row from the upper left.
  [[nodiscard]] std::vector<cv::Point2d> Corners(const BoardPose& pose) const;

 private:
  Board board_;
  Lens lens_;
  cv::Mat1f sheet_;              // 0 black, 255 white
  cv::Point2d first_corner_px_;  // on the sheet
  std::vector<cv::Vec3d> rays_;
};

/// A pose whose board's centre is seen at a part of the image (0 to 1 from left and top).
/// @param across_rad, along_rad  tilts about the sheet's x and y. @param turn_rad  about the view.
/// @param width_ratio  how much of the image's width the board would fill, level and in the
/// centre.
BoardPose PoseAt(const Board& board,
                 const Lens& lens,
                 cv::Point2d at,
                 double across_rad,
                 double along_rad,
                 double turn_rad,
                 double width_ratio);

/// A chessboard with squares of 25 mm.
Board TestBoard();

/// Fifteen views as a person would take them: all parts of the image, tilts to all sides.
std::vector<BoardPose> GoodPoses(const Board& board, const Lens& lens);

/// A 480 x 360 camera with some barrel distortion whose centre is not the image's.
Lens TestLens();

}  // namespace ceilmap::calibration
