#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/solve/board_detector.hpp"
#include "calib/solve/camera_solver.hpp"

namespace ceilmap::calibration {

/// Which parts of the image boards were seen in.
struct Coverage {
  static constexpr int kColumns = 12;
  static constexpr int kRows = 9;
  /// How many boards cover each cell's centre, row by row: kColumns x kRows cells of one size.
  std::vector<int> boards;
  /// Corners in each ninth of the image, row by row.
  std::vector<int> corners_in_ninths;

  /// Cells that a board covers, of all of them, 0 to 1.
  [[nodiscard]] double Share() const;
  /// Ninths without a corner as a person calls them: "the lower left".
  [[nodiscard]] std::vector<std::string> EmptyNinths() const;
};
Coverage FindCoverage(const std::vector<BoardView>& views, cv::Size size);

/// Views left when of those that show the board in the same place only the first counts: all
/// corners within a hundredth of the image's diagonal, on average.
std::size_t DistinctViews(const std::vector<BoardView>& views, cv::Size size);

/// True where edges are wider than a quarter of the squares, so that corners pull at each other, or
/// three times as wide as `usual_edge_px`, the median of the recording.
bool IsBlurred(const BoardView& view, double usual_edge_px);
/// Median of the views' edges; 0 without any that is known.
double UsualEdge(const std::vector<BoardView>& views);

/// What speaks against a solution, a line each that ends with what to add.
struct Judgement {
  std::vector<std::string> faults;    ///< it must not be used
  std::vector<std::string> warnings;  ///< it can be better
};
/// @param coverage  of the views that were used.
Judgement JudgeCamera(const CameraSolution& solution, const Coverage& coverage);

}  // namespace ceilmap::calibration
