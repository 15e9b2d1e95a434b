#include "calib/solve/levelling.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace ceilmap::calibration {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Levelling::Levelling(double x, double y)
    : R(Matrix3d::Identity()), left_jacobian(Eigen::Matrix<double, 3, 2>::Identity()) {
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
  const Matrix3d square = cross * cross;
  R += sine * cross + versine * square;
  left_jacobian += (versine * cross + (1 - sine) / (angle * angle) * square).leftCols<2>();
}

LevelPoint::LevelPoint(const Levelling& levelling,
                       const Eigen::Vector2d& ray,
                       const Eigen::Matrix2d& R_to_level) {
  const Vector3d level = levelling.R * ray.homogeneous();
  place = R_to_level * level.hnormalized();
  Eigen::Matrix<double, 2, 3> by_level;
  by_level << R_to_level, -place;
  by_level /= level.z();
  by_ray = by_level * levelling.R.leftCols<2>();
  by_tilt = -by_level * CrossMatrix(level) * levelling.left_jacobian;
}

}  // namespace ceilmap::calibration
