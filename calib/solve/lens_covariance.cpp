#include "calib/solve/lens_covariance.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace ceilmap::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Derivatives of a view's pixels by the lens, projected orthogonally to those by its pose.
MatrixXd ByLensAlone(const Lens& lens,
                     const BoardPose& pose,
                     const std::vector<cv::Point3d>& points) {
  MatrixXd by_lens;
  MatrixXd by_pose;
  Project(lens, pose, points, &by_lens, &by_pose);
  const MatrixXd pose_information = by_pose.transpose() * by_pose;
  return by_lens - by_pose * pose_information.ldlt().solve(by_pose.transpose() * by_lens);
}

VectorXd Stacked(const std::vector<cv::Point2d>& residuals) {
  VectorXd stacked(2 * static_cast<Index>(residuals.size()));
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    stacked.segment<2>(2 * static_cast<Index>(i)) << residuals[i].x, residuals[i].y;
  }
  return stacked;
}

std::vector<Index> Indices(const std::vector<bool>& free) {
  std::vector<Index> indices;
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (free[i]) indices.push_back(static_cast<Index>(i));
  }
  return indices;
}

}  // namespace

MatrixXd LensInformation(const Lens& lens,
                         const BoardPose& pose,
                         const std::vector<cv::Point3d>& points) {
  const MatrixXd alone = ByLensAlone(lens, pose, points);
  return alone.transpose() * alone;
}

MatrixXd LensCovariance(const Lens& lens,
                        const std::vector<FittedView>& views,
                        const std::vector<bool>& free) {
  const std::vector<Index> kept = Indices(free);
  const auto values = static_cast<Index>(kept.size());
  MatrixXd information = MatrixXd::Zero(values, values);
  MatrixXd disagreement = MatrixXd::Zero(values, values);
  double squares = 0;
  double spare = -static_cast<double>(values);  // number of measurements minus number of estimates
  for (const FittedView& view : views) {
    const VectorXd residuals = Stacked(*view.residuals_px);
    const MatrixXd alone = ByLensAlone(lens, view.pose, *view.points)(Eigen::all, kept);
    const VectorXd gradient = alone.transpose() * residuals;
    information += alone.transpose() * alone;
    disagreement += gradient * gradient.transpose();
    squares += residuals.squaredNorm();
    spare += static_cast<double>(residuals.size() - kPoseValues);
  }
  const auto count = static_cast<double>(views.size());
  const MatrixXd inverse = information.ldlt().solve(MatrixXd::Identity(values, values));
  const MatrixXd by_curvature = squares / std::max(1.0, spare) * inverse;
  const MatrixXd by_views = count / std::max(1.0, count - 1) * inverse * disagreement * inverse;
  const VectorXd growth =
      (by_views.diagonal().array() / by_curvature.diagonal().array()).max(1.0).sqrt().matrix();
  const Index values_count = lens.Values().size();
  MatrixXd covariance = MatrixXd::Zero(values_count, values_count);
  covariance(kept, kept) = growth.asDiagonal() * by_curvature * growth.asDiagonal();
  return covariance;
}

}  // namespace ceilmap::calibration
