#include "compensation/forward_solver.hpp"

#include <cmath>

#include "compensation/rig_cameras.hpp"

namespace ceilmap::compensation {
namespace {

// Standard deviation added when the ceiling gives no motion and parallax is neglected, as a
// fraction of the tilt.
constexpr double kWithoutParallaxRatio = 0.1;

double Squared(double value) {
  return value * value;
}

/// A camera that looks down or up shows a wall narrower by cos(pitch) and lower by its square. The
/// registered zoom contains the mean of both factors.
double WithoutKeystone(double zoom, double tan_shift) {
  return zoom * std::pow(1 + tan_shift * tan_shift, -0.75);
}

}  // namespace

ForwardSolver::ForwardSolver(const calib::Rig& rig,
                             double camera_yaw_rad,
                             const ForwardSolverParams& params)
    : yaw_rad_(camera_yaw_rad),
      params_(params),
      front_climbs_(TiltModel(-rig.axle_behind_mast_m, rig.ceiling_height_m), ForwardHeight(rig)),
      // The rig does not give the position of the wheels before the mast. It affects only the
      // height of the mast's foot, by millimetres.
      rear_climbs_(TiltModel(0, rig.ceiling_height_m), ForwardHeight(rig)),
      wall_(params.wall_per_m, params.wall_per_m_sigma) {}

std::optional<TiltAngles> ForwardSolver::Solve(const ForwardMotion& seen,
                                               std::optional<double> ceiling_motion_m) {
  double pitch = std::atan(seen.tan_shift);
  double variance = Squared(seen.sigma_tan_shift);
  if (ceiling_motion_m) {
    const ForwardEquation& equation = seen.tan_shift < 0 ? front_climbs_ : rear_climbs_;
    std::optional<ForwardTilt> found;
    double base_shift_m = *ceiling_motion_m;
    constexpr int kRounds = 2;  // the wall's distance depends weakly on the base shift
    for (int round = 0; round < kRounds; ++round) {
      found =
          equation.SolveFromWall({seen.tan_shift, wall_.PerMetre(base_shift_m), *ceiling_motion_m})
              .Unique();
      if (!found) return std::nullopt;
      base_shift_m = found->base_shift_m;
    }
    pitch = found->tilt_rad;
    const ForwardSensitivity& by = found->sensitivity;
    variance = Squared(by.by_tan_shift * seen.sigma_tan_shift) +
               Squared(by.by_wall_per_m * wall_.Sigma(base_shift_m)) +
               Squared(by.by_seen_motion_m * params_.ceiling_motion_sigma_m);
    // For the next frame: this one was solved with the earlier estimate of the wall.
    wall_.Learn(WithoutKeystone(seen.zoom, seen.tan_shift), seen.sigma_zoom, base_shift_m);
  } else {
    variance += Squared(kWithoutParallaxRatio * pitch);
  }
  return InAxesOfBase(yaw_rad_, {pitch, seen.roll_rad}, {variance, Squared(seen.sigma_roll_rad)});
}

}  // namespace ceilmap::compensation
