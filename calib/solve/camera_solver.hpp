#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"
#include "calib/solve/board_projection.hpp"

namespace ceilmap::calibration {

struct SolverParams {
  LensModel model = LensModel::kPlumbBob;
  /// Fixes coefficients to zero that the views do not need (Schwarz's criterion); else all
  /// coefficients of the model are free.
  bool choose_terms = true;
};

/// A view and its residuals.
struct SolvedView {
  std::size_t view = 0;  ///< index in the input of SolveCamera
  BoardPose pose;
  std::vector<cv::Point2d> residuals_px;  ///< measured minus modelled, as BoardView::corners_px
  double rms_px = 0;                      ///< root of the mean squared length
  double tilt_rad = 0;                    ///< between the board's normal and the camera's axis
  bool used = true;                       ///< false: left out as an outlier
};

/// A calibrated camera.
struct CameraSolution {
  Lens lens;
  /// Of Lens::Values, see LensCovariance. k1, k2, p1 and p2 (of a fisheye k1, k2) are included even
  /// if they were fixed: they do not differ from zero significantly, which contributes to the
  /// uncertainty of focal lengths and centre. Rows and columns of other fixed values are zero.
  Eigen::MatrixXd covariance;
  std::vector<bool> free;         ///< which of Lens::Values were estimated
  double rms_px = 0;              ///< root of the mean squared length over all used corners
  std::size_t corners = 0;        ///< number of used corners
  std::vector<SolvedView> views;  ///< in the input order; including those left out

  /// Standard deviation of a value; infinite when the views do not determine it.
  [[nodiscard]] double Sigma(Eigen::Index i) const;
  /// Accuracy of the lens in the image's corners: standard deviation, in pixels, of the position
  /// where the directions of the corners appear; the maximum of the four. If the lens model ends
  /// before a corner, its last position on the line to the corner is used; infinite when there is
  /// none.
  [[nodiscard]] double CornerSigma() const;
  [[nodiscard]] std::size_t UsedViews() const;
};

/// Minimises the squared distances between measured and modelled corners over the lens and the
/// board's pose in every view (Zhang 2000). Views that do not fit are left out one at a time, and
/// the fit is repeated.
///
/// @param views  At least 3, of the same image size.
/// @return nothing when no solution was found: the views do not determine a lens of this model.
std::optional<CameraSolution> SolveCamera(const Board& board,
                                          const std::vector<BoardView>& views,
                                          cv::Size size,
                                          const SolverParams& params = {});

}  // namespace ceilmap::calibration
