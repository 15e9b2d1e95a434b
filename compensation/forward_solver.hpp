#pragma once

#include <Eigen/Core>
#include <optional>

#include "calib/rig.hpp"
#include "compensation/forward_equation.hpp"
#include "compensation/forward_tracker.hpp"
#include "compensation/tilt_filter.hpp"
#include "compensation/wall_distance.hpp"

namespace ceilmap::compensation {

struct ForwardSolverParams {
  /// Of what is believed of the wall ahead before it is measured, 1/m.
  double wall_per_m = 0.2;
  double wall_per_m_sigma = 0.15;
  /// Standard deviation of the motion that the ceiling shows, m.
  double ceiling_motion_sigma_m = 0.003;
  /// Where the ceiling shows no motion: what leaving out parallax costs, part of the tilt.
  double without_parallax_ratio = 0.1;
};

/// Pitch and roll from the forward camera's motion: Eq. (1) of Matsumoto et al. 2010. The zoom of
/// one frame that is near its keyframe says little of the wall's distance, so that is learned from
/// the zoom of all frames, and the equation solved with it.
class ForwardSolver {
 public:
  /// @param rig  with a forward camera. @param camera_yaw_rad  where that looks, from base's x
  /// axis.
  /// @throws InputError for a rig that cannot be.
  ForwardSolver(const calib::Rig& rig,
                double camera_yaw_rad,
                const ForwardSolverParams& params = {});

  /// @param seen  against the level keyframe. @param ceiling_motion_m  Cx of Eq. (1): the motion
  /// from the frame to the keyframe along the camera's direction that the upward camera shows when
  /// it takes both for level; unset: not known, parallax is left out.
  /// @return nothing when no tilt agrees, or several do.
  std::optional<TiltAngles> Solve(const ForwardMotion& seen,
                                  std::optional<double> ceiling_motion_m);

  /// A new keyframe, which stands so much farther along the camera's direction.
  void MoveKeyframe(double metres) { wall_.MoveAhead(metres); }

 private:
  double yaw_rad_;
  ForwardSolverParams params_;
  ForwardEquation front_climbs_;
  ForwardEquation rear_climbs_;
  WallDistance wall_;
};

}  // namespace ceilmap::compensation
