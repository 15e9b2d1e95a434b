#pragma once

#include "calib/solve/rig_problem.hpp"
#include "calib/solve/rig_solver.hpp"

namespace ceilmap::calibration {

/// RigSolution::covariance of a solved problem. Internal to RigSolver.
/// @param sigma_px  Standard deviation of points in the problem.
RigCovarianceMatrix RigCovariance(RigProblem& problem,
                                  const Recording& spin,
                                  const Recording& straight,
                                  const RigParameters& parameters,
                                  const RigSolverParams& params,
                                  double sigma_px);

}  // namespace ceilmap::calibration
