#include "calib/solve/drive_residual.hpp"

#include <Eigen/Geometry>

#include "calib/solve/levelling.hpp"
#include "calib/solve/pair_problem.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct SeenPoint {
  Vector2d place;
  Eigen::Matrix<double, 2, kCameraErrors> by_errors;
  Vector2d by_rho;
};

/// The direction (x/z, y/z) of the point from the camera at the time of the image's middle row.
SeenPoint OnCeiling(const LevelRay& sight, const DriveState& state, const Levelling& levelling) {
  const Eigen::Map<const Vector3d> lens(state.errors + kCameraFocal);
  const Vector2d slope = sight.slope + sight.by_lens * lens;
  const double time = state.errors[kCameraReadout] * sight.row;
  const LevelPoint point(
      levelling, slope, Eigen::Rotation2Dd(sight.velocity.yaw_rad_s * time).toRotationMatrix());
  SeenPoint seen;
  seen.place = point.place + sight.velocity.linear * (state.rho * time);
  seen.by_errors.leftCols<2>() = point.by_tilt;
  seen.by_errors.middleCols<3>(kCameraFocal) = point.by_ray * sight.by_lens;
  seen.by_errors.col(kCameraReadout) =
      sight.row *
      (sight.velocity.yaw_rad_s * QuarterTurn(point.place) + state.rho * sight.velocity.linear);
  seen.by_rho = time * sight.velocity.linear;
  return seen;
}

class PointCost final : public ceres::CostFunction {
 public:
  PointCost(const DrivePoint& point, const Matrix2d& weight) : point_(&point), weight_(weight) {
    set_num_residuals(2);
    *mutable_parameter_block_sizes() = {kCameraErrors, 3, 3};
    if (point.height >= 0) mutable_parameter_block_sizes()->push_back(1);
  }

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const bool has_height = point_->height >= 0;
    const DriveState state{
        parameters[0], parameters[1], parameters[2], has_height ? *parameters[3] : 1.0};
    DriveErrorDerivatives derivatives;
    Eigen::Map<Vector2d> residual(residuals);
    residual = weight_ * ErrorOf(*point_, state, jacobians == nullptr ? nullptr : &derivatives);
    if (jacobians == nullptr) return true;
    WriteJacobian(weight_, derivatives.by_errors, jacobians[0]);
    WriteJacobian(weight_, derivatives.by_first, jacobians[1]);
    WriteJacobian(weight_, derivatives.by_second, jacobians[2]);
    if (has_height) WriteJacobian(weight_, derivatives.by_rho, jacobians[3]);
    return true;
  }

 private:
  const DrivePoint* point_;
  Matrix2d weight_;
};

}  // namespace

Vector2d ErrorOf(const DrivePoint& point,
                 const DriveState& state,
                 DriveErrorDerivatives* derivatives) {
  const Levelling levelling(state.errors[kCameraTiltX], state.errors[kCameraTiltY]);
  const SeenPoint first = OnCeiling(point.at_first, state, levelling);
  const SeenPoint second = OnCeiling(point.at_second, state, levelling);
  const Vector2d travel(state.second[0] - state.first[0], state.second[1] - state.first[1]);
  const Matrix2d R_first_ceiling = Eigen::Rotation2Dd(-state.first[2]).toRotationMatrix();
  const Matrix2d R_first_second =
      Eigen::Rotation2Dd(state.second[2] - state.first[2]).toRotationMatrix();
  const Vector2d moved = R_first_ceiling * travel;
  const Vector2d turned = R_first_second * second.place;
  // A longer focal length makes the ceiling smaller, but not the errors in the image.
  const double size = 1 / (1 - state.errors[kCameraFocal]);
  Vector2d error = size * (state.rho * moved + turned - first.place);
  if (derivatives != nullptr) {
    DriveErrorDerivatives& d = *derivatives;
    d.by_errors = size * (R_first_second * second.by_errors - first.by_errors);
    d.by_errors.col(kCameraFocal) += size * error;
    d.by_second << size * state.rho * R_first_ceiling, size * QuarterTurn(turned);
    d.by_first << -size * state.rho * R_first_ceiling,
        -size * QuarterTurn(state.rho * moved + turned);
    d.by_rho = size * (moved + R_first_second * second.by_rho - first.by_rho);
  }
  return error;
}

ceres::CostFunction* NewPointCost(const DrivePoint& point, const Matrix2d& weight) {
  return new PointCost(point, weight);
}

}  // namespace ceilmap::calibration
