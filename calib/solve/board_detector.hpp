#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calib/solve/board.hpp"

namespace ceilmap::calibration {

/// A board as an image shows it.
struct BoardView {
  std::string name;                     ///< of the image
  std::vector<cv::Point2d> corners_px;  ///< (0, 0) is the centre of the top-left pixel
  std::vector<int> ids;                 ///< Board::Corner of each, rising
  /// Width of the edges between squares, from 10 to 90 % of their contrast: 1 to 3 px in a sharp
  /// image.
  double edge_px = 0;
  double square_px = 0;  ///< shortest way from a corner to its neighbour in the same row or column
};

/// Finds the board's corners, to some hundredths of a pixel in a sharp image. A chessboard must
/// be seen whole; of a ChArUco board, six corners are enough.
///
/// Corners come from OpenCV's sector-based detector, or the classic one where that finds none, or
/// from the markers, and are refined by RefineCorner: the sector-based places alone put the focal
/// length 0.3 to 0.6 % too high (calib/README.md). Corners where no squares meet are left out; with
/// more than a fifth of such there is no board.
/// @param grey  CV_8UC1. Thread-safe.
std::optional<BoardView> DetectBoard(const cv::Mat& grey, const Board& board);

/// What is in an image in which DetectBoard finds nothing, or what it found is not what it seems.
struct BoardGuess {
  enum class Kind {
    kNothing,
    kOtherSize,  ///< a chessboard of `corners`
    kMirrored,   ///< the board, but as a mirror shows it
    kBlurred,    ///< the board, once the image is made smaller
    kMarkers,    ///< markers of the dictionary, but not the board
  };
  Kind kind = Kind::kNothing;
  cv::Size corners;
};
BoardGuess GuessBoard(const cv::Mat& grey, const Board& board);
/// kOtherSize with the size of the one chessboard that is seen, or kNothing.
BoardGuess GuessSize(const cv::Mat& grey);

}  // namespace ceilmap::calibration
