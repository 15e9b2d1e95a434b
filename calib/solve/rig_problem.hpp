#pragma once

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "calib/solve/pair_problem.hpp"
#include "calib/solve/rig_solver.hpp"

namespace ceilmap::calibration {

/// The parameters of the fit and its residuals. Internal to RigSolver.
struct RigParameters {
  std::array<double, 2> tilt{};
  std::array<double, 2> centre{};
  std::array<double, 1> yaw{};
  std::array<double, 1> readout{};  // s
  bool readout_is_free = false;
  using Pose = std::array<double, 3>;  // x, y, heading
  std::vector<Pose> spin;
  std::vector<Pose> straight;
};

/// Standard deviations of the three kinds of residuals.
struct RigScales {
  double place_px = 1;
  double wander = 0.01;
  double slip = 0.003;
};

/// Error of a point in pixels of the first image, weighted; not divided by its standard deviation.
Eigen::Vector2d PlaceError(const RigParameters& parameters,
                           const std::vector<RigParameters::Pose>& poses,
                           const Recording& recording,
                           const ViewPair& pair,
                           const PointCorrespondence& place,
                           double focal_px);

/// Sideways step between consecutive views, in units of Z.
double SlipOf(const RigParameters& parameters, std::size_t view);

/// Distance of the camera between the first and last view of the straight drive, units of Z.
Eigen::Vector2d TravelOf(const RigParameters& parameters);

/// The problem of a spin and a straight drive. The views of the straight drive follow those of the
/// spin.
struct RigProblem : PairProblem {
  RigProblem(const Recording& spin,
             const Recording& straight,
             const RigSolverParams& params,
             const RigScales& scales,
             RigParameters& parameters);

 private:
  void AddPlaces(const Recording& recording,
                 double focal_px,
                 double sigma_px,
                 std::vector<RigParameters::Pose>& poses,
                 int first_view);
  void AddSpin(double wander);
  void AddStraight(double slip);
  void Hold();

  RigParameters& parameters_;
};

}  // namespace ceilmap::calibration
