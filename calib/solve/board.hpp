#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ceilmap::calibration {

enum class BoardKind : std::uint8_t {
  kChessboard,
  kCharuco,  ///< a chessboard with markers in its white squares; may be partly visible
};

/// A flat calibration board. Its frame: corners in rows along x, the rows along y, z = 0, metres.
struct Board {
  BoardKind kind = BoardKind::kChessboard;
  int columns =
      9;  ///< corners where four squares meet, along the longer side: one less than squares
  int rows = 6;
  double square_m = 0;                ///< side of a square, > 0
  double marker_m = 0;                ///< side of a marker, less than a square's; only for kCharuco
  std::string dictionary = "4x4_50";  ///< of the markers: SIZExSIZE_COUNT, as in OpenCV

  /// @throws InputError naming the field: corners, square, marker or dictionary.
  void Validate() const;

  [[nodiscard]] int CornerCount() const { return columns * rows; }
  [[nodiscard]] cv::Point3d Corner(int id) const {
    const int row = id / columns;
    const int column = id % columns;
    return {column * square_m, row * square_m, 0};
  }
  /// "chessboard of 9x6 corners".
  [[nodiscard]] std::string Name() const;
};

/// `CxR`, both whole numbers, at least 3 and at most 60. @throws InputError
cv::Size ParseCorners(const std::string& text);

/// "chessboard" or "charuco". @throws InputError
BoardKind ParseBoardKind(const std::string& text);

/// Image of a marker, one cell per bit, with its black frame: 0 black, 255 white.
cv::Mat1b MarkerCells(const std::string& dictionary, int id);

/// Number of markers of a dictionary. @throws InputError when there is none of that name.
int MarkerCount(const std::string& dictionary);

/// OpenCV's number of a dictionary. @throws InputError with a list of the names.
int DictionaryId(const std::string& dictionary);

}  // namespace ceilmap::calibration
