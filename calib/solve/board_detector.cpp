#include "calib/solve/board_detector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "calib/solve/corner_refiner.hpp"

namespace ceilmap::calibration {
namespace {

constexpr int kSearchSidePx =
    1600;  // longer images are searched at reduced size and refined at full size
constexpr int kMinCharucoCorners = 6;

using Corners = std::vector<cv::Point2f>;

// Image for the search, and the scale factor to the original.
double Reduce(const cv::Mat& grey, int longest_px, cv::Mat& small) {
  const int side = std::max(grey.cols, grey.rows);
  if (side <= longest_px) {
    small = grey;
    return 1;
  }
  const double scale = static_cast<double>(side) / longest_px;
  cv::resize(grey, small, {}, 1 / scale, 1 / scale, cv::INTER_AREA);
  return scale;
}

void Enlarge(double scale, Corners& corners) {
  for (cv::Point2f& p : corners) {
    p.x = static_cast<float>((p.x + 0.5) * scale - 0.5);
    p.y = static_cast<float>((p.y + 0.5) * scale - 0.5);
  }
}

bool FindBySectors(const cv::Mat& grey, cv::Size size, Corners& corners) {
  constexpr int kFlags =
      cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY;
  return cv::findChessboardCornersSB(grey, size, corners, kFlags);
}

bool FindByQuads(const cv::Mat& grey, cv::Size size, Corners& corners) {
  constexpr int kFlags =
      cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  return cv::findChessboardCorners(grey, size, corners, kFlags);
}

// Distance from each corner to the nearest neighbour in its row and column, pixels; for a corner
// without detected neighbours, the smallest of all.
std::vector<double> NeighbourDistances(const Corners& corners,
                                       const std::vector<int>& ids,
                                       int columns) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  std::vector<double> nearest(corners.size(), kUnknown);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    for (std::size_t j = i + 1; j < ids.size() && ids[j] <= ids[i] + columns; ++j) {
      const bool same_row = ids[j] == ids[i] + 1 && ids[j] % columns != 0;
      if (!same_row && ids[j] != ids[i] + columns) continue;
      const double distance = cv::norm(corners[i] - corners[j]);
      nearest[i] = std::min(nearest[i], distance);
      nearest[j] = std::min(nearest[j], distance);
    }
  }
  constexpr double kNoNeighboursPx = 10;
  const double least = *std::min_element(nearest.begin(), nearest.end());
  std::replace(
      nearest.begin(), nearest.end(), kUnknown, least < kUnknown ? least : kNoNeighboursPx);
  return nearest;
}

// Weights end before the next corners, whose edges would cause errors. A smaller window may still
// fit at the border of the image.
// @return number of corners without a saddle: they keep their position, and `found` is false.
std::size_t Refine(const cv::Mat& grey,
                   const std::vector<double>& nearest,
                   double bell_ratio,
                   Corners& corners,
                   std::vector<bool>& found) {
  constexpr double kMaxBellPx = 6;
  constexpr double kMinBellPx = 1;
  constexpr double kFarthestRatio = 0.15;
  found.assign(corners.size(), false);
  std::size_t missing = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double bell_px = std::clamp(bell_ratio * nearest[i], kMinBellPx, kMaxBellPx);
    const double farthest_px = std::max(1.0, kFarthestRatio * nearest[i]);
    for (const double fraction : {1.0, 0.5}) {
      const auto corner =
          RefineCorner(grey, corners[i], std::max(kMinBellPx, fraction * bell_px), farthest_px);
      if (!corner) continue;
      corners[i] = *corner;
      found[i] = true;
      break;
    }
    missing += found[i] ? 0 : 1;
  }
  return missing;
}

// Without the corners that have no saddle; nothing when these are more than a fifth.
std::optional<BoardView> KeepFound(BoardView view, const std::vector<bool>& found) {
  constexpr std::size_t kMaxMissing = 5;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i]) continue;
    view.corners_px[kept] = view.corners_px[i];
    view.ids[kept++] = view.ids[i];
  }
  if (kMaxMissing * (found.size() - kept) > found.size()) return std::nullopt;
  view.corners_px.resize(kept);
  view.ids.resize(kept);
  return view;
}

double EdgeWidth(const cv::Mat& grey, cv::Size size, const Corners& corners) {
  constexpr float kRise = 0.8F;  // from 10 to 90 %
  try {
    const double along = cv::estimateChessboardSharpness(grey, size, corners, kRise, false)[0];
    const double across = cv::estimateChessboardSharpness(grey, size, corners, kRise, true)[0];
    return std::max(along, across);
  } catch (const cv::Exception&) {
    return 0;  // squares of only a few pixels
  }
}

// A grid of corners, and which of them were detected.
struct Grid {
  BoardView view;
  std::vector<bool> found;
  std::size_t missing = 0;
};

std::optional<Grid> FindGrid(const cv::Mat& grey,
                             const Board& board,
                             bool (*find)(const cv::Mat&, cv::Size, Corners&)) {
  const cv::Size size(board.columns, board.rows);
  cv::Mat small;
  const double scale = Reduce(grey, kSearchSidePx, small);
  Corners corners;
  if (!find(small, size, corners)) return std::nullopt;
  Enlarge(scale, corners);
  Grid grid;
  for (int id = 0; id < board.CornerCount(); ++id) grid.view.ids.push_back(id);
  constexpr double kBellRatio = 0.2;
  const std::vector<double> nearest = NeighbourDistances(corners, grid.view.ids, board.columns);
  grid.missing = Refine(grey, nearest, kBellRatio, corners, grid.found);
  grid.view.corners_px.assign(corners.begin(), corners.end());
  grid.view.edge_px = EdgeWidth(grey, size, corners);
  grid.view.square_px = *std::min_element(nearest.begin(), nearest.end());
  return grid;
}

// The sector-based detector extrapolates corners that are not visible; with strong distortion they
// are wrong.
std::optional<BoardView> DetectChessboard(const cv::Mat& grey, const Board& board) {
  std::optional<Grid> grid = FindGrid(grey, board, FindBySectors);
  if (!grid || grid->missing > 0) {
    std::optional<Grid> other = FindGrid(grey, board, FindByQuads);
    if (other && (!grid || other->missing < grid->missing)) grid = std::move(other);
  }
  if (!grid) return std::nullopt;
  return KeepFound(std::move(grid->view), grid->found);
}

struct Charuco {
  explicit Charuco(const Board& board)
      : dictionary(cv::aruco::getPredefinedDictionary(DictionaryId(board.dictionary))),
        layout(cv::aruco::CharucoBoard::create(board.columns + 1,
                                               board.rows + 1,
                                               static_cast<float>(board.square_m),
                                               static_cast<float>(board.marker_m),
                                               dictionary)) {}
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  cv::Ptr<cv::aruco::CharucoBoard> layout;
};

// @return number of detected markers of the dictionary.
std::size_t FindCharuco(const cv::Mat& grey,
                        const Charuco& charuco,
                        Corners& corners,
                        std::vector<int>& ids) {
  corners.clear();
  ids.clear();
  std::vector<Corners> markers;
  std::vector<int> marker_ids;
  cv::aruco::detectMarkers(grey, charuco.dictionary, markers, marker_ids);
  if (marker_ids.empty()) return 0;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, grey, charuco.layout, corners, ids);
  return marker_ids.size();
}

// Corners whose positions agree with the board, within the distortion of a lens.
bool FitsBoard(const Corners& corners, const std::vector<int>& ids, const Charuco& charuco) {
  if (ids.size() < kMinCharucoCorners) return false;
  Corners on_board;
  for (const int id : ids) {
    const cv::Point3f p = charuco.layout->chessboardCorners[static_cast<std::size_t>(id)];
    on_board.emplace_back(p.x, p.y);
  }
  const cv::Rect2f extent = cv::boundingRect(corners);
  const double tolerance_px = std::max(2.0, 0.05 * std::max(extent.width, extent.height));
  std::vector<unsigned char> inliers;
  const cv::Mat H = cv::findHomography(on_board, corners, cv::RANSAC, tolerance_px, inliers);
  constexpr double kFitting = 0.8;
  return !H.empty() && cv::countNonZero(inliers) >= kFitting * static_cast<double>(ids.size());
}

std::optional<BoardView> DetectCharuco(const cv::Mat& grey, const Board& board) {
  const Charuco charuco(board);
  Corners corners;
  std::vector<int> ids;
  FindCharuco(grey, charuco, corners, ids);
  if (!FitsBoard(corners, ids, charuco)) return std::nullopt;
  constexpr double kBellRatio = 0.12;  // markers begin near the corners, but symmetrically
  const std::vector<double> nearest = NeighbourDistances(corners, ids, board.columns);
  std::vector<bool> found;
  Refine(grey, nearest, kBellRatio, corners, found);
  BoardView view;
  view.corners_px.assign(corners.begin(), corners.end());
  view.ids = ids;
  view.square_px = *std::min_element(nearest.begin(), nearest.end());
  return KeepFound(std::move(view), found);
}

}  // namespace

std::optional<BoardView> DetectBoard(const cv::Mat& grey, const Board& board) {
  return board.kind == BoardKind::kCharuco ? DetectCharuco(grey, board)
                                           : DetectChessboard(grey, board);
}

BoardGuess GuessSize(const cv::Mat& grey) {
  constexpr int kFlags =
      cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_LARGER;
  cv::Mat small;
  Reduce(grey, kSearchSidePx, small);
  Corners corners;
  cv::Mat meta;
  if (!cv::findChessboardCornersSB(small, {3, 3}, corners, kFlags, meta)) return {};
  const cv::Size size(std::max(meta.cols, meta.rows), std::min(meta.cols, meta.rows));
  return {BoardGuess::Kind::kOtherSize, size};
}

BoardGuess GuessBoard(const cv::Mat& grey, const Board& board) {
  using Kind = BoardGuess::Kind;
  cv::Mat small;
  if (board.kind == BoardKind::kCharuco) {
    cv::Mat flipped;
    cv::flip(grey, flipped, 1);
    if (DetectBoard(flipped, board)) return {Kind::kMirrored, {}};
    Corners corners;
    std::vector<int> ids;
    if (FindCharuco(grey, Charuco(board), corners, ids) >= 2) return {Kind::kMarkers, {}};
  }
  for (const int side_px : {640, 320, 160}) {
    if (side_px >= std::max(grey.cols, grey.rows)) continue;
    Reduce(grey, side_px, small);
    if (DetectBoard(small, board)) return {Kind::kBlurred, {}};
  }
  return GuessSize(grey);
}

}  // namespace ceilmap::calibration
