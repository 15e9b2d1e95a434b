#pragma once

#include <Eigen/Core>

namespace ceilmap::calibration {

/// The cross product with a vector as a matrix.
inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Derivative by the angle of a vector that was turned by it.
inline Eigen::Vector2d QuarterTurn(const Eigen::Vector2d& v) {
  return {-v.y(), v.x()};
}

/// Rotation of a camera's axes to level ones by the rotation vector (x, y, 0). Internal to the
/// solvers.
struct Levelling {
  Levelling(double x, double y);

  Eigen::Matrix3d R;
  Eigen::Matrix<double, 3, 2> left_jacobian;  ///< d(R p) = -[R p]x left_jacobian d(x, y)
};

/// Where a ray of the camera meets the ceiling, from the camera, in units of Z: the distance of the
/// ceiling.
struct LevelPoint {
  /// @param ray  (x/z, y/z) in the camera's axes. z of the levelled ray must be positive.
  /// @param R_to_level  rotation in the plane from the levelled axes to those of the result.
  LevelPoint(const Levelling& levelling,
             const Eigen::Vector2d& ray,
             const Eigen::Matrix2d& R_to_level);

  Eigen::Vector2d place;
  Eigen::Matrix2d by_ray;
  Eigen::Matrix2d by_tilt;  ///< by x and y of the levelling
};

}  // namespace ceilmap::calibration
