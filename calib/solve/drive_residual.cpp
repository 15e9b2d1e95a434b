#include "calib/solve/drive_residual.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace ceilmap::calibration {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Matrix3d CrossMatrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Derivative of Rotation2Dd(angle) * v by the angle is the turned vector, a quarter turn further.
Vector2d QuarterTurn(const Vector2d& v) {
  return {-v.y(), v.x()};
}

/// Levelling of the camera's axes by the rotation vector (x, y, 0).
struct Levelling {
  Matrix3d R = Matrix3d::Identity();
  Eigen::Matrix<double, 3, 2> left_jacobian = Eigen::Matrix<double, 3, 2>::Identity();

  Levelling(double x, double y) {
    const Vector3d turn(x, y, 0);
    const double angle = turn.norm();
    const Matrix3d cross = CrossMatrix(turn);
    constexpr double kSmall = 1e-8;
    if (angle < kSmall) {
      R += cross;
      left_jacobian += 0.5 * cross.leftCols<2>();
      return;
    }
    const double sine = std::sin(angle) / angle;
    const double versine = (1 - std::cos(angle)) / (angle * angle);
    R += sine * cross + versine * cross * cross;
    left_jacobian += (versine * cross + (1 - sine) / (angle * angle) * cross * cross).leftCols<2>();
  }
};

struct SeenPoint {
  Vector2d place;
  Eigen::Matrix<double, 2, kCameraErrors> by_errors;
  Vector2d by_rho;
};

/// The direction (x/z, y/z) of the point from the camera at the time of the image's middle row.
SeenPoint OnCeiling(const LevelRay& sight, const DriveState& state, const Levelling& levelling) {
  const Eigen::Map<const Vector3d> lens(state.errors + kCameraFocal);
  const Vector2d slope = sight.slope + sight.by_lens * lens;
  const Vector3d level = levelling.R * slope.homogeneous();
  const Vector2d level_slope = level.hnormalized();
  const double time = state.errors[kCameraReadout] * sight.row;
  const Matrix2d turn = Eigen::Rotation2Dd(sight.velocity.yaw_rad_s * time).toRotationMatrix();
  const Vector2d turned = turn * level_slope;
  Eigen::Matrix<double, 2, 3> by_level;
  by_level << turn, -turned;
  by_level /= level.z();
  SeenPoint seen;
  seen.place = turned + sight.velocity.linear * (state.rho * time);
  seen.by_errors.leftCols<2>() = -by_level * CrossMatrix(level) * levelling.left_jacobian;
  seen.by_errors.middleCols<3>(kCameraFocal) = by_level * levelling.R.leftCols<2>() * sight.by_lens;
  seen.by_errors.col(kCameraReadout) = sight.row * (sight.velocity.yaw_rad_s * QuarterTurn(turned) +
                                                    state.rho * sight.velocity.linear);
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
    using ByPose = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
    using ByErrors = Eigen::Matrix<double, 2, kCameraErrors, Eigen::RowMajor>;
    if (jacobians[0] != nullptr) {
      Eigen::Map<ByErrors>(jacobians[0]).noalias() = weight_ * derivatives.by_errors;
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<ByPose>(jacobians[1]).noalias() = weight_ * derivatives.by_first;
    }
    if (jacobians[2] != nullptr) {
      Eigen::Map<ByPose>(jacobians[2]).noalias() = weight_ * derivatives.by_second;
    }
    if (has_height && jacobians[3] != nullptr) {
      Eigen::Map<Vector2d>(jacobians[3]).noalias() = weight_ * derivatives.by_rho;
    }
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
