#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "calib/solve/board.hpp"
#include "calib/solve/board_detector.hpp"
#include "calib/solve/board_projection.hpp"
#include "calib/solve/camera_solver.hpp"

namespace ceilmap::calibration {

/// A lens and the board's poses.
struct CameraEstimate {
  Lens lens;
  std::vector<std::array<double, kPoseValues>> poses;            ///< of all views, rotation first
  double squares_px2 = std::numeric_limits<double>::infinity();  ///< sum of squared residuals
};

/// The least-squares fit of a lens and of the board's poses to the corners of several views. Views
/// can be left out. Internal to SolveCamera.
class CameraProblem {
 public:
  /// The references must outlive the object.
  CameraProblem(const Board& board,
                const std::vector<BoardView>& views,
                cv::Size size,
                LensModel model);

  void LeaveOut(std::size_t view) { used_[view] = false; }
  /// Number of corners of the views that are not left out.
  [[nodiscard]] std::size_t UsedCorners() const;

  /// The best of several initial values, after a fit of focal lengths, centre and two coefficients;
  /// nothing where the board's pose cannot be found under any, or no fit converges.
  [[nodiscard]] std::optional<CameraEstimate> Start() const;
  /// Fits the free values of the lens and all poses. @param free  which of Lens::Values.
  void Minimise(const std::vector<bool>& free, CameraEstimate& estimate) const;
  /// The result, with residuals and covariance. @param free  as Minimise estimated them.
  [[nodiscard]] CameraSolution Solution(const CameraEstimate& estimate,
                                        std::vector<bool> free) const;

 private:
  [[nodiscard]] std::vector<double> FocalGuesses() const;
  [[nodiscard]] std::optional<CameraEstimate> StartAt(double focal_px) const;
  void SetViews(const CameraEstimate& estimate, CameraSolution& solution) const;
  [[nodiscard]] Eigen::MatrixXd Covariance(const CameraSolution& solution,
                                           const std::vector<bool>& free) const;

  const Board& board_;
  const std::vector<BoardView>& views_;
  cv::Size size_;
  LensModel model_;
  std::vector<bool> used_;
  std::vector<std::vector<cv::Point3d>> points_;
};

}  // namespace ceilmap::calibration
