#include "calib/solve/rig_solver.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "calib/base/statistics.hpp"
#include "calib/solve/rig_covariance.hpp"
#include "calib/solve/rig_problem.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
// Lower bounds of the deviations that are estimated from the data: sideways slip from view to view
// and motion of the axle in a spin, both in units of Z, and the error of a point.
constexpr double kMinSlip = 5e-5;
constexpr double kMinWander = 5e-5;
constexpr double kMinSigmaPx = 0.005;

RigParameters StartParameters(const Recording& spin,
                              const Recording& straight,
                              const RigMount& start) {
  RigParameters parameters;
  parameters.tilt = {start.tilt_rad.x(), start.tilt_rad.y()};
  parameters.centre = {start.centre.x(), start.centre.y()};
  parameters.yaw = {start.yaw_rad};
  parameters.readout = {start.readout_time_s};
  // Headings are continuous: a spin may exceed a full turn.
  double heading = 0;
  for (const Pose2& camera : spin.cameras) {
    heading += WrapAngle(camera.yaw - heading);
    parameters.spin.push_back({0, 0, heading});
  }
  // The axle starts at the origin.
  for (const Pose2& camera : straight.cameras) {
    const Vector2d axle = camera.Translation() + start.centre - camera.Rotation() * start.centre;
    parameters.straight.push_back({axle.x(), axle.y(), camera.yaw});
  }
  return parameters;
}

void AddErrors(const Recording& recording,
               const RigParameters& parameters,
               const std::vector<RigParameters::Pose>& poses,
               double focal_px,
               std::vector<double>& errors_px) {
  for (const ViewPair& pair : recording.pairs) {
    for (const PointCorrespondence& place : pair.places) {
      errors_px.push_back(PlaceError(parameters, poses, recording, pair, place, focal_px).norm());
    }
  }
}

std::vector<double> ErrorsOf(const Recording& spin,
                             const Recording& straight,
                             const RigParameters& parameters,
                             double focal_px) {
  std::vector<double> errors_px;
  AddErrors(spin, parameters, parameters.spin, focal_px, errors_px);
  AddErrors(straight, parameters, parameters.straight, focal_px, errors_px);
  return errors_px;
}

// Standard deviations of the residuals; those of the wheels too, when their views are free.
RigScales ScalesOf(const Recording& spin,
                   const Recording& straight,
                   const RigParameters& parameters,
                   double focal_px) {
  constexpr double kMedianOfTwo = 1.1774;  // of the length of a normal error in two axes
  RigScales scales;
  std::vector<double> errors_px = ErrorsOf(spin, straight, parameters, focal_px);
  scales.place_px = std::max(kMinSigmaPx, Median(errors_px) / kMedianOfTwo);
  std::vector<double> wander;
  for (const auto& pose : parameters.spin) wander.push_back(std::hypot(pose[0], pose[1]));
  scales.wander = std::max(kMinWander, Median(wander) / kMedianOfTwo);
  std::vector<double> slip;
  for (std::size_t i = 0; i + 1 < parameters.straight.size(); ++i) {
    slip.push_back(std::abs(SlipOf(parameters, i)));
  }
  constexpr double kMedianOfOne = 0.6745;
  scales.slip = kMinSlip;
  if (!slip.empty()) scales.slip = std::max(scales.slip, Median(slip) / kMedianOfOne);
  return scales;
}

std::vector<ViewError> ViewErrors(const Recording& recording,
                                  const RigParameters& parameters,
                                  const std::vector<RigParameters::Pose>& poses,
                                  double focal_px) {
  std::vector<ViewError> errors(poses.size());
  for (const ViewPair& pair : recording.pairs) {
    for (const PointCorrespondence& place : pair.places) {
      const double square =
          PlaceError(parameters, poses, recording, pair, place, focal_px).squaredNorm();
      for (const int view : {pair.first, pair.second}) {
        ViewError& error = errors[static_cast<std::size_t>(view)];
        error.rms_px += square;
        ++error.places;
      }
    }
  }
  for (ViewError& error : errors) {
    if (error.places > 0) error.rms_px = std::sqrt(0.5 * error.rms_px / error.places);
  }
  return errors;
}

std::vector<Pose2> ToPoses(const std::vector<RigParameters::Pose>& poses) {
  std::vector<Pose2> result;
  result.reserve(poses.size());
  for (const auto& pose : poses) result.push_back({pose[0], pose[1], pose[2]});
  return result;
}

RigSolution SolutionOf(const Recording& spin,
                       const Recording& straight,
                       const RigParameters& parameters,
                       double focal_px,
                       double sigma_px) {
  RigSolution solution;
  solution.ok = true;
  solution.mount = {{parameters.tilt[0], parameters.tilt[1]},
                    {parameters.centre[0], parameters.centre[1]},
                    WrapAngle(parameters.yaw[0]),
                    parameters.readout[0]};
  solution.travel = TravelOf(parameters).norm();
  solution.spin = ToPoses(parameters.spin);
  solution.straight = ToPoses(parameters.straight);
  solution.spin_errors = ViewErrors(spin, parameters, parameters.spin, focal_px);
  solution.straight_errors = ViewErrors(straight, parameters, parameters.straight, focal_px);
  solution.sigma_px = sigma_px;
  const std::vector<double> errors_px = ErrorsOf(spin, straight, parameters, focal_px);
  solution.places = static_cast<int>(errors_px.size());
  solution.inliers = static_cast<int>(std::count_if(
      errors_px.begin(), errors_px.end(), [&](double e) { return e < 3 * sigma_px; }));
  return solution;
}

}  // namespace

Vector2d RigMount::CentreInBase() const {
  return Pose2{0, 0, yaw_rad} * centre;
}

RigMount GuessMount(const Recording& spin, const Recording& straight) {
  RigMount mount;
  // p_i = p_0 + (R_i - 1) c for all views of the spin.
  const auto n = static_cast<Eigen::Index>(spin.cameras.size());
  MatrixXd A(2 * n, 4);
  VectorXd b(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Pose2& camera = spin.cameras[static_cast<std::size_t>(i)];
    A.block<2, 2>(2 * i, 0) = camera.Rotation() - Eigen::Matrix2d::Identity();
    A.block<2, 2>(2 * i, 2).setIdentity();
    b.segment<2>(2 * i) = camera.Translation();
  }
  const VectorXd x = A.colPivHouseholderQr().solve(b);
  mount.centre = x.head<2>();
  if (straight.cameras.size() < 2) return mount;
  // Forward in the axes of the levelled camera is (cos yaw, -sin yaw).
  const Pose2& last = straight.cameras.back();
  const Vector2d moved = Pose2{0, 0, -0.5 * last.yaw} * last.Translation();
  mount.yaw_rad = std::atan2(-moved.y(), moved.x());
  return mount;
}

RigSolution SolveRig(const Recording& spin,
                     const Recording& straight,
                     const RigMount& start,
                     const RigSolverParams& params,
                     bool readout_is_free) {
  RigParameters parameters = StartParameters(spin, straight, start);
  parameters.readout_is_free = readout_is_free;
  if (parameters.spin.size() < 3 || ErrorsOf(spin, straight, parameters, 1).empty()) return {};
  RigScales scales;  // initially wide: errors of the wheels are not yet known
  scales.place_px = ScalesOf(spin, straight, parameters, params.focal_px).place_px;
  constexpr int kRounds = 5;
  constexpr int kIterations = 50;  // of a round, at most
  for (int round = 0; round < kRounds; ++round) {
    RigProblem problem(spin, straight, params, scales, parameters);
    if (!Minimise(problem, kIterations)) return {};
    if (round + 1 == kRounds) {
      RigSolution solution =
          SolutionOf(spin, straight, parameters, params.focal_px, scales.place_px);
      solution.covariance =
          RigCovariance(problem, spin, straight, parameters, params, scales.place_px);
      solution.ok = solution.covariance.allFinite();  // else the views do not determine all values
      return solution;
    }
    scales = ScalesOf(spin, straight, parameters, params.focal_px);
  }
  return {};
}

}  // namespace ceilmap::calibration
