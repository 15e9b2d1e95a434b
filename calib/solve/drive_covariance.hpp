#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "calib/solve/drive_problem.hpp"

namespace ceilmap::calibration {

/// Covariance of the estimated errors (DriveProblem::estimated) of a solved problem. Errors are
/// taken to be common to the points of a pair, to the pairs of a view, and to the views of an
/// eighth of the drive; each variance is the largest of those, and of the curvature of the cost.
/// Internal to the drive solver.
/// @param views  number of images of the drive.
Eigen::MatrixXd DriveCovariance(DriveProblem& problem, std::size_t views);

}  // namespace ceilmap::calibration
