#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "app/recordings/ceiling_keyframes.hpp"
#include "calib/rig.hpp"
#include "calib/solve/rig_solver.hpp"

namespace ceilmap::recordings {

/// What a tape measured, in metres; one of the two at least.
struct TapeMeasures {
  std::optional<double> ceiling_height_m;  ///< above the floor
  std::optional<double> distance_m;        ///< from where the straight drive began to its end
  double sigma_m = 0.001;                  ///< of either, > 0

  [[nodiscard]] bool GivesCameraHeight() const { return ceiling_height_m && distance_m; }
};

/// A value with its standard deviation.
struct Measured {
  double value = 0;
  double sigma = 0;
};

/// How the upward camera is mounted, in the rig's terms. Angles of the mount: p_base = Rx(roll)
/// Ry(pitch) Rz(yaw) p_cam.
struct RigCalibration {
  Measured axle_behind_mast_m;
  Measured camera_y_m;
  Measured camera_z_m;  ///< sigma 0: taken from the rig
  Measured yaw_rad;
  Measured pitch_rad;
  Measured roll_rad;
  Measured ceiling_height_m;
  Measured distance_m;      ///< Z: of the ceiling above the camera
  Measured m_per_px;        ///< on the ceiling, of the levelled image
  Measured drive_length_m;  ///< of the straight drive, from its first frame to its last
  Eigen::Isometry3d T_base_up = Eigen::Isometry3d::Identity();
  calibration::RigSolution solution;
  double wander_m = 0;    ///< of the axle in the spin, RMS
  double turn_rad = 0;    ///< of the spin, from the least heading to the greatest
  double course_rad = 0;  ///< of the straight drive, likewise
};

/// Solves for the mount of the rig's upward camera, measuring anew with each better mount until it
/// stands still.
/// @param rig  its upward camera as far as it is known; the place along base x is kept.
/// @param lens_sigma_px  see calibration::RigSolverParams.
/// @throws InputError when a recording is not what it should be: a spin that does not turn
///   or drives away, a straight drive that turns or is too short.
RigCalibration CalibrateRig(const calib::Rig& rig,
                            const CeilingKeyframes& spin,
                            const CeilingKeyframes& straight,
                            const TapeMeasures& tape,
                            double lens_sigma_px);

}  // namespace ceilmap::recordings
