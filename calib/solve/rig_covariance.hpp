#pragma once

#include <Eigen/Core>

#include "calib/solve/rig_problem.hpp"
#include "calib/solve/rig_solver.hpp"

namespace ceilmap::calibration {

/// RigSolution::covariance of a problem that is solved. Internal to RigSolver.
/// @param sigma_px  the deviation of places that the problem was made with.
Eigen::Matrix<double, 6, 6> RigCovariance(RigProblem& problem,
                                          const Recording& spin,
                                          const Recording& straight,
                                          const RigParameters& parameters,
                                          const RigSolverParams& params,
                                          double sigma_px);

}  // namespace ceilmap::calibration
