#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calib/solve/board.hpp"

namespace ceilmap::calibration {

/// A board in an image.
struct BoardView {
  std::string name;                     ///< of the image
  std::vector<cv::Point2d> corners_px;  ///< (0, 0) is the centre of the top-left pixel
  std::vector<int> ids;                 ///< Board::Corner of each, increasing
  /// Width of the edges between squares, from 10 to 90 % of their contrast: 1 to 3 px in a sharp
  /// image.
  double edge_px = 0;
  double square_px = 0;  ///< shortest distance between neighbouring corners
};

/// Finds the board's corners, to some hundredths of a pixel in a sharp image. A chessboard must be
/// completely visible; of a ChArUco board, six corners are enough.
///
/// Corners come from OpenCV's sector-based detector, or from the classic one if that fails, or from
/// the markers, and are refined by RefineCorner: with the positions of the sector-based detector,
/// the focal length is 0.3 to 0.6 % too large (calib/README.md). Corners without a saddle are left
/// out; with more than a fifth of such corners there is no board.
/// @param grey  CV_8UC1. Thread-safe.
std::optional<BoardView> DetectBoard(const cv::Mat& grey, const Board& board);

/// Reason why DetectBoard finds no board, or a wrong one.
struct BoardGuess {
  enum class Kind {
    kNothing,
    kOtherSize,  ///< a chessboard of `corners`
    kMirrored,   ///< the board, mirrored
    kBlurred,    ///< the board, found only at reduced size
    kMarkers,    ///< markers of the dictionary, but not the board
  };
  Kind kind = Kind::kNothing;
  cv::Size corners;
};
BoardGuess GuessBoard(const cv::Mat& grey, const Board& board);
/// kOtherSize with the size of the only chessboard in the image, or kNothing.
BoardGuess GuessSize(const cv::Mat& grey);

}  // namespace ceilmap::calibration
