#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"
#include "calib/solve/lens.hpp"

namespace ceilmap::calibration {

struct SolverParams {
  LensModel model = LensModel::kPlumbBob;
  /// Leaves coefficients at zero that the views do not need (Schwarz's criterion); else all of the
  /// model's are free.
  bool choose_terms = true;
};

/// A view and how well it fits.
struct SolvedView {
  std::size_t view = 0;  ///< in what was given to SolveCamera
  BoardPose pose;
  std::vector<cv::Point2d> residuals_px;  ///< measured minus modelled, as BoardView::corners_px
  double rms_px = 0;                      ///< root of the mean squared length
  double tilt_rad = 0;                    ///< between the board's normal and the camera's axis
  bool used = true;                       ///< false: left out as an outlier
};

/// A calibrated camera.
struct CameraSolution {
  Lens lens;
  /// Of Lens::values, see LensCovariance. k1, k2, p1 and p2 (of a fisheye k1, k2) count as if they
  /// had been estimated where they were not: that the views do not tell them from zero leaves
  /// something open, for focal lengths and centre too. Rows and columns of other values left at
  /// zero are zero.
  Eigen::MatrixXd covariance;
  std::vector<bool> free;         ///< which of Lens::values were estimated
  double rms_px = 0;              ///< root of the mean squared length over all corners used
  std::size_t corners = 0;        ///< used
  std::vector<SolvedView> views;  ///< in the order given; also those left out

  /// Standard deviation of a value; infinite where the views leave it open altogether.
  [[nodiscard]] double Sigma(Eigen::Index i) const;
  /// How well the lens is known in the image's corners: standard deviation, in pixels, of where
  /// the directions show that the corners look into; the greatest of the four. Where the
  /// lens's model ends before the corners, its last place on the way there stands for them;
  /// infinite when there is none.
  [[nodiscard]] double CornerSigma() const;
  [[nodiscard]] std::size_t UsedViews() const;
};

/// Minimises the squared distances between measured and modelled corners over the lens and the
/// board's pose in every view (Zhang 2000), then leaves out views that do not fit, one at a time,
/// and starts again.
///
/// @param views  at least 3, of one image size.
/// @return nothing when no solution was found: views from which no lens of this model follows.
std::optional<CameraSolution> SolveCamera(const Board& board,
                                          const std::vector<BoardView>& views,
                                          cv::Size size,
                                          const SolverParams& params = {});

}  // namespace ceilmap::calibration
