#pragma once

#include <ceres/cost_function.h>

#include <Eigen/Core>

#include "calib/solve/drive_solver.hpp"

namespace ceilmap::calibration {

/// One sight of a point, prepared. Internal to the drive solver.
struct LevelRay {
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< (x/z, y/z) in the levelled axes
  /// Change of the slope by kCameraFocal, kCameraRadial3, kCameraRadial5.
  Eigen::Matrix<double, 2, 3> by_lens = Eigen::Matrix<double, 2, 3>::Zero();
  double row = 0;  ///< of the raw image that showed it: -0.5 .. 0.5
  ViewVelocity velocity;
};

struct DrivePoint {
  int first = 0;
  int second = 0;
  LevelRay at_first;
  LevelRay at_second;
  Eigen::Matrix2d whitening = Eigen::Matrix2d::Identity();
  int height = -1;  ///< index of DriveParameters::heights; -1: in the plane
};

/// What the error of a point depends on.
struct DriveState {
  const double* errors = nullptr;  ///< of the camera: kCameraErrors values
  const double* first = nullptr;   ///< camera pose of the first image: x, y in units of Z, yaw
  const double* second = nullptr;
  double rho = 1;  ///< height ratio of the point
};

struct DriveErrorDerivatives {
  Eigen::Matrix<double, 2, kCameraErrors> by_errors;
  Eigen::Matrix<double, 2, 3> by_first;
  Eigen::Matrix<double, 2, 3> by_second;
  Eigen::Vector2d by_rho;
};

/// Difference between the point of the first image and that of the second, in the axes of the first
/// levelled camera, in units of Z times 1 / (1 - kCameraFocal): in pixels when multiplied by the
/// focal length of the rig.
/// @param derivatives  unless null: receives those of the difference.
Eigen::Vector2d ErrorOf(const DrivePoint& point,
                        const DriveState& state,
                        DriveErrorDerivatives* derivatives);

/// The weighted error as a residual of the camera's errors, the two poses, and rho where the point
/// has a height. The caller owns the result. @param point  must outlive it.
ceres::CostFunction* NewPointCost(const DrivePoint& point, const Eigen::Matrix2d& weight);

}  // namespace ceilmap::calibration
