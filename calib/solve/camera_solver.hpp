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
  /// A view is left out whose RMS is more than so many times the views' median, > 1.
  double outlier_factor = 3;
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
  /// Of Lens::values; rows and columns of values that were not estimated are zero.
  ///
  /// From the curvature of the squared residuals and from how the views disagree, the greater of
  /// the two: corner errors of one view (a bent board, shading) are not independent.
  Eigen::MatrixXd covariance;
  std::vector<bool> free;         ///< which of Lens::values were estimated
  double rms_px = 0;              ///< root of the mean squared length over all corners used
  std::size_t corners = 0;        ///< used
  std::vector<SolvedView> views;  ///< in the order given; also those left out

  /// Standard deviation of a value.
  [[nodiscard]] double Sigma(Eigen::Index i) const;
  /// Standard deviation, in pixels, of where the picture's corners show: how far the uncertainty of
  /// the distortion moves them, once focal lengths and centre have taken their part.
  [[nodiscard]] double CornerSigma() const;
  [[nodiscard]] std::size_t UsedViews() const;
};

/// Minimises the squared distances between measured and modelled corners over the lens and the
/// board's pose in every view (Zhang 2000), then leaves out views that do not fit, one at a time,
/// and starts again.
///
/// @param views  at least 3, of one picture size.
/// @return nothing when no solution was found: views from which no lens of this model follows.
std::optional<CameraSolution> SolveCamera(const Board& board,
                                          const std::vector<BoardView>& views,
                                          cv::Size size,
                                          const SolverParams& params = {});

/// What a view tells of the lens: information of Lens::values with the view's pose taken out, per
/// square pixel of corner noise.
Eigen::MatrixXd LensInformation(const Lens& lens,
                                const BoardPose& pose,
                                const std::vector<cv::Point3d>& points);

/// The board's corners that a view shows.
std::vector<cv::Point3d> BoardPoints(const Board& board, const BoardView& view);

/// The pose that fits a view best, for a lens that is known. Nothing when there is none.
std::optional<BoardPose> FindPose(const Lens& lens, const Board& board, const BoardView& view);

}  // namespace ceilmap::calibration
