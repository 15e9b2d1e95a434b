#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/solve/board_detector.hpp"
#include "calib/solve/camera_solver.hpp"

namespace ceilmap::calibration {

/// Coverage of the image by boards.
struct Coverage {
  static constexpr int kColumns = 12;
  static constexpr int kRows = 9;
  /// Number of boards over each cell's centre, by rows: kColumns x kRows cells of the same size.
  std::vector<int> boards;
  /// Corners in each ninth of the image, row by row.
  std::vector<int> corners_in_ninths;

  /// Fraction of cells that a board covers, 0 to 1.
  [[nodiscard]] double Share() const;
  /// Names of ninths without a corner: "the lower left".
  [[nodiscard]] std::vector<std::string> EmptyNinths() const;
};
Coverage FindCoverage(const std::vector<BoardView>& views, cv::Size size);

/// Number of distinct views: of views with the board at the same position only the first one
/// counts. Same: a mean distance of the corners below a hundredth of the image's diagonal.
std::size_t DistinctViews(const std::vector<BoardView>& views, cv::Size size);

/// True when edges are wider than a quarter of the squares, so that corners affect each other, or
/// three times as wide as `usual_edge_px`, the median of the recording.
bool IsBlurred(const BoardView& view, double usual_edge_px);
/// Median of the views' edge widths; 0 when none is known.
double UsualEdge(const std::vector<BoardView>& views);

/// Problems of a solution, one line each, with the views to add.
struct Judgement {
  std::vector<std::string> faults;    ///< it must not be used
  std::vector<std::string> warnings;  ///< it can be improved
};
/// @param coverage  Of the used views.
Judgement JudgeCamera(const CameraSolution& solution, const Coverage& coverage);

}  // namespace ceilmap::calibration
