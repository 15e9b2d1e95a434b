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
  /// Expected inverse distance of the wall ahead before any measurement, and its standard
  /// deviation, 1/m.
  double wall_per_m = 0.2;
  double wall_per_m_sigma = 0.15;
  /// Standard deviation of the motion measured by the ceiling, m.
  double ceiling_motion_sigma_m = 0.003;
};

/// Pitch and roll from the motion in the forward camera: Eq. (1) of Matsumoto et al. 2010. The zoom
/// of one frame near its keyframe determines the distance of the wall poorly. The distance is
/// therefore estimated from the zoom of all frames, and the equation is solved with it. See
/// compensation/README.md, "Tilt from the forward camera".
class ForwardSolver {
 public:
  /// @param rig  A rig with a forward camera.
  /// @param camera_yaw_rad  Direction of the forward camera's view, from the x axis of base.
  /// @throws InputError for an impossible rig.
  ForwardSolver(const calib::Rig& rig,
                double camera_yaw_rad,
                const ForwardSolverParams& params = {});

  /// @param seen  Motion against the level keyframe.
  /// @param ceiling_motion_m  Cx of Eq. (1): the motion from the frame to the keyframe along the
  ///   camera's direction, by the upward camera when both frames are taken as level. Unset:
  ///   unknown, parallax is neglected.
  /// @return nothing when no tilt agrees, or when several do.
  std::optional<TiltAngles> Solve(const ForwardMotion& seen,
                                  std::optional<double> ceiling_motion_m);

  /// Registers a new keyframe, which stands `metres` farther along the camera's direction.
  void MoveKeyframe(double metres) { wall_.MoveAhead(metres); }

 private:
  double yaw_rad_;
  ForwardSolverParams params_;
  ForwardEquation front_climbs_;
  ForwardEquation rear_climbs_;
  WallDistance wall_;
};

}  // namespace ceilmap::compensation
