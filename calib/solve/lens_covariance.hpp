#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/solve/lens.hpp"

namespace ceilmap::calibration {

/// What a view tells of the lens: information of Lens::values with the view's pose taken out, per
/// square pixel of corner noise.
Eigen::MatrixXd LensInformation(const Lens& lens,
                                const BoardPose& pose,
                                const std::vector<cv::Point3d>& points);

/// A view after the fit.
struct FittedView {
  BoardPose pose;
  const std::vector<cv::Point3d>* points = nullptr;
  const std::vector<cv::Point2d>* residuals_px = nullptr;
};

/// Covariance of Lens::values at a fit's minimum; rows and columns of values that are not `free`
/// are zero.
///
/// From the curvature of the squared residuals, whose size tells the corners' noise, and from how
/// the views disagree (the "sandwich" with a view as the unit: corner errors of one view, of a bent
/// board or of shading, are not independent); for each value the greater of the two, correlations
/// from the curvature.
Eigen::MatrixXd LensCovariance(const Lens& lens,
                               const std::vector<FittedView>& views,
                               const std::vector<bool>& free);

}  // namespace ceilmap::calibration
