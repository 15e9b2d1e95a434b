#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/solve/board_projection.hpp"

namespace ceilmap::calibration {

/// Information of one view on Lens::Values, with the view's pose eliminated, per square pixel of
/// corner noise.
Eigen::MatrixXd LensInformation(const Lens& lens,
                                const BoardPose& pose,
                                const std::vector<cv::Point3d>& points);

/// A view after the fit.
struct FittedView {
  BoardPose pose;
  const std::vector<cv::Point3d>* points = nullptr;
  const std::vector<cv::Point2d>* residuals_px = nullptr;
};

/// Covariance of Lens::Values at the minimum of a fit; rows and columns of values that are not
/// `free` are zero.
///
/// Computed from the curvature of the squared residuals, whose size gives the corners' noise, and
/// from the differences between views (a sandwich estimator with views as clusters, because corner
/// errors of one view, of a bent board or of shading, are not independent); for each value the
/// larger of both, with correlations from the curvature.
Eigen::MatrixXd LensCovariance(const Lens& lens,
                               const std::vector<FittedView>& views,
                               const std::vector<bool>& free);

}  // namespace ceilmap::calibration
