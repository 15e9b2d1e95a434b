#pragma once

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "calib/solve/rig_solver.hpp"

namespace ceilmap::calibration {

/// The parameters of the fit and its residuals. Internal to RigSolver.
struct RigParameters {
  std::array<double, 2> tilt{};
  std::array<double, 2> centre{};
  std::array<double, 1> yaw{};
  using Pose = std::array<double, 3>;  // x, y, heading
  std::vector<Pose> spin;
  std::vector<Pose> straight;
};

/// Deviations of the three kinds of residuals.
struct RigScales {
  double place_px = 1;
  double wander = 0.01;
  double slip = 0.003;
};

/// Who a residual block of the problem belongs to.
struct BlockOwner {
  ceres::ResidualBlockId id = nullptr;
  int first = -1;   ///< view, those of the straight drive after those of the spin
  int second = -1;  ///< -1: of one view alone
  bool place = false;
};

/// Error of a place in pixels of the first image, weighted; not divided by its deviation.
Eigen::Vector2d PlaceError(const RigParameters& parameters,
                           const std::vector<RigParameters::Pose>& poses,
                           const ViewPair& pair,
                           const PointCorrespondence& place,
                           double focal_px);

/// Sideways step, in units of Z, from a view to the next.
double SlipOf(const RigParameters& parameters, std::size_t view);

/// How far the camera went from the first view of the straight drive to the last, units of Z.
Eigen::Vector2d TravelOf(const RigParameters& parameters);

/// A least-squares problem whose residuals all have deviation 1.
struct RigProblem {
  RigProblem(const Recording& spin,
             const Recording& straight,
             double focal_px,
             const RigScales& scales,
             RigParameters& parameters);

  ceres::Problem problem;
  std::vector<BlockOwner> owners;
  /// All that are free, in the order of Jacobians.
  std::vector<double*> blocks;

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

/// Cauchy's parameter in deviations: keeps 95 % of the efficiency.
constexpr double kCauchy = 2.3849;

}  // namespace ceilmap::calibration
