#pragma once

#include <ceres/sized_cost_function.h>

#include <Eigen/Core>

#include "calib/solve/rig_solver.hpp"

namespace ceilmap::calibration {

/// A point that two views show, and how the camera moved while they were exposed. Internal to the
/// rig solver.
struct PlaceSights {
  const PointCorrespondence* place = nullptr;
  ViewVelocity first_velocity;
  ViewVelocity second_velocity;
};

/// What the error of a point depends on.
struct PlaceState {
  const double* tilt = nullptr;    ///< of the camera about its x and y, rad
  const double* centre = nullptr;  ///< of the camera from the axle, in units of Z
  double readout_s = 0;
  const double* first = nullptr;  ///< the robot's pose: x, y in units of Z, heading
  const double* second = nullptr;
};

struct PlaceDerivatives {
  Eigen::Matrix2d by_tilt;
  Eigen::Matrix2d by_centre;
  Eigen::Vector2d by_readout;
  Eigen::Matrix<double, 2, 3> by_first;
  Eigen::Matrix<double, 2, 3> by_second;
};

/// Difference between the point of the first image and that of the second, transformed to the
/// first, in units of Z. @param derivatives  unless null: receives those of the difference.
Eigen::Vector2d PlaceDifference(const PlaceSights& sights,
                                const PlaceState& state,
                                PlaceDerivatives* derivatives);

/// The weighted difference as a residual of tilt, centre, read-out time and the two poses. The
/// caller owns the result. The place of the sights must outlive it.
ceres::CostFunction* NewPlaceCost(const PlaceSights& sights, const Eigen::Matrix2d& weight);

}  // namespace ceilmap::calibration
