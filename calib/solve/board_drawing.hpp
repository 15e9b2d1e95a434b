#pragma once

#include <string>
#include <vector>

#include "calib/solve/board.hpp"

namespace ceilmap::calibration {

/// A sheet of paper, millimetres.
struct Paper {
  std::string name;
  double width_mm = 0;  ///< the shorter side
  double height_mm = 0;
};
/// "a4", "a3" or "letter". @throws InputError
Paper ParsePaper(const std::string& name);

/// A board on a sheet, to scale: its image, a ruler to check the scale of the print, and a line
/// with its parameters. Coordinates from the sheet's upper left corner, y down.
struct BoardDrawing {
  struct Rectangle {
    double x_mm, y_mm, width_mm, height_mm;
    bool white = false;  ///< drawn above black ones
  };
  double width_mm = 0;  ///< of the sheet, with the orientation in which the board fits
  double height_mm = 0;
  std::vector<Rectangle> rectangles;  ///< in order
  double ruler_x_mm = 0;              ///< its left end; 100 mm long, marks every 10 mm
  double ruler_y_mm = 0;
  std::string text;  ///< right of the ruler
};

/// The upper left square of a chessboard is black. A ChArUco board is that of OpenCV's aruco
/// module: lower left square black, markers from the upper left on.
/// @throws InputError when the board does not fit on the sheet with the margin that detectors need.
BoardDrawing DrawBoard(const Board& board, const Paper& paper);

/// The drawing as a file for printers, in millimetres.
std::string FormatSvg(const BoardDrawing& drawing);
std::string FormatPdf(const BoardDrawing& drawing);

}  // namespace ceilmap::calibration
