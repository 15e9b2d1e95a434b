#include "calib/solve/board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <opencv2/aruco.hpp>
#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap::calibration {
namespace {

constexpr int kMinCorners = 3;
constexpr int kMaxCorners = 60;

struct NamedDictionary {
  const char* name;
  int id;
  int markers;
};
constexpr std::array<NamedDictionary, 17> kDictionaries = {{
    {"4x4_50", cv::aruco::DICT_4X4_50, 50},
    {"4x4_100", cv::aruco::DICT_4X4_100, 100},
    {"4x4_250", cv::aruco::DICT_4X4_250, 250},
    {"4x4_1000", cv::aruco::DICT_4X4_1000, 1000},
    {"5x5_50", cv::aruco::DICT_5X5_50, 50},
    {"5x5_100", cv::aruco::DICT_5X5_100, 100},
    {"5x5_250", cv::aruco::DICT_5X5_250, 250},
    {"5x5_1000", cv::aruco::DICT_5X5_1000, 1000},
    {"6x6_50", cv::aruco::DICT_6X6_50, 50},
    {"6x6_100", cv::aruco::DICT_6X6_100, 100},
    {"6x6_250", cv::aruco::DICT_6X6_250, 250},
    {"6x6_1000", cv::aruco::DICT_6X6_1000, 1000},
    {"7x7_50", cv::aruco::DICT_7X7_50, 50},
    {"7x7_100", cv::aruco::DICT_7X7_100, 100},
    {"7x7_250", cv::aruco::DICT_7X7_250, 250},
    {"7x7_1000", cv::aruco::DICT_7X7_1000, 1000},
    {"original", cv::aruco::DICT_ARUCO_ORIGINAL, 1024},
}};

const NamedDictionary& FindDictionary(const std::string& name) {
  const auto* const found = std::find_if(kDictionaries.begin(),
                                         kDictionaries.end(),
                                         [&](const NamedDictionary& d) { return name == d.name; });
  if (found != kDictionaries.end()) return *found;
  throw InputError(
      fmt::format("dictionary {}: must be 4x4, 5x5, 6x6 or 7x7, then _50, _100, _250 or _1000, or "
                  "original; see the board's margin or its source",
                  name));
}

bool ParseCount(std::string_view text, int& count) {
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, count);
  return result.ec == std::errc() && result.ptr == end;
}

}  // namespace

std::string Board::Name() const {
  return fmt::format("{} of {}x{} corners",
                     kind == BoardKind::kCharuco ? "ChArUco board" : "chessboard",
                     columns,
                     rows);
}

void Board::Validate() const {
  const auto check_count = [this](int count) {
    if (count >= kMinCorners && count <= kMaxCorners) return;
    throw InputError(fmt::format(
        "corners {}x{}: each count must be {} to {}", columns, rows, kMinCorners, kMaxCorners));
  };
  check_count(columns);
  check_count(rows);
  if (!(square_m > 0 && square_m <= 10)) {
    throw InputError(
        fmt::format("square {}: must be the side of a square in metres, e.g. 0.025", square_m));
  }
  if (kind == BoardKind::kChessboard) return;
  if (!(marker_m > 0 && marker_m < square_m)) {
    throw InputError(
        fmt::format("marker {}: must be the side of a marker in metres, less than the square's {}",
                    marker_m,
                    square_m));
  }
  const int markers = (columns + 1) * (rows + 1) / 2;
  if (markers > MarkerCount(dictionary)) {
    throw InputError(
        fmt::format("dictionary {}: has {} markers, the board needs {}; take a larger one",
                    dictionary,
                    MarkerCount(dictionary),
                    markers));
  }
}

cv::Size ParseCorners(const std::string& text) {
  const std::size_t cross = text.find('x');
  cv::Size corners;
  if (cross == std::string::npos || !ParseCount(text.substr(0, cross), corners.width) ||
      !ParseCount(text.substr(cross + 1), corners.height)) {
    throw InputError(
        fmt::format("corners {}: must be COLUMNSxROWS of inner corners (where four squares "
                    "meet), e.g. 9x6 for "
                    "10x7 squares",
                    text));
  }
  return corners;
}

BoardKind ParseBoardKind(const std::string& text) {
  if (text == "chessboard") return BoardKind::kChessboard;
  if (text == "charuco") return BoardKind::kCharuco;
  throw InputError(fmt::format("board {}: must be chessboard or charuco", text));
}

int DictionaryId(const std::string& dictionary) {
  return FindDictionary(dictionary).id;
}

int MarkerCount(const std::string& dictionary) {
  return FindDictionary(dictionary).markers;
}

cv::Mat1b MarkerCells(const std::string& dictionary, int id) {
  const auto markers = cv::aruco::getPredefinedDictionary(DictionaryId(dictionary));
  cv::Mat1b cells;
  markers->drawMarker(id, markers->markerSize + 2, cells, 1);
  return cells;
}

}  // namespace ceilmap::calibration
