#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "app/recordings/ceiling_keyframes.hpp"
#include "calib/rig.hpp"
#include "calib/solve/rig_solver.hpp"

namespace ceilmap::recordings {

/// Tape measurements in metres; at least one of the two lengths.
struct TapeMeasures {
  std::optional<double> ceiling_height_m;  ///< above the floor
  std::optional<double> distance_m;        ///< between the start and the end of the straight drive
  double sigma_m = 0.001;                  ///< of both, > 0

  [[nodiscard]] bool GivesCameraHeight() const { return ceiling_height_m && distance_m; }
};

/// A value with its standard deviation.
struct Measured {
  double value = 0;
  double sigma = 0;
};

/// Mount of the upward camera, in the terms of the rig. Angles: p_base = Rx(roll) Ry(pitch) Rz(yaw)
/// p_cam.
struct RigCalibration {
  Measured axle_behind_mast_m;
  Measured camera_y_m;
  Measured camera_z_m;  ///< sigma 0: taken from the rig
  Measured yaw_rad;
  Measured pitch_rad;
  Measured roll_rad;
  Measured ceiling_height_m;
  Measured distance_m;      ///< Z: from the camera to the ceiling
  Measured m_per_px;        ///< on the ceiling, of the levelled image
  Measured drive_length_m;  ///< of the straight drive, from its first frame to its last
  Eigen::Isometry3d T_base_up = Eigen::Isometry3d::Identity();
  calibration::RigSolution solution;
  double wander_m = 0;    ///< of the axle in the spin, RMS
  double turn_rad = 0;    ///< of the spin, from the smallest heading to the largest
  double course_rad = 0;  ///< of the straight drive, the same
};

/// Solves for the mount of the rig's upward camera. Measurements are repeated with each better
/// mount until it converges.
/// @param rig  With the approximate upward camera; the position along base x is not changed.
/// @param lens_sigma_px  See calibration::RigSolverParams.
/// @throws InputError when a recording is not as required: a spin that does not turn or moves away,
/// a straight drive that turns or is too short.
RigCalibration CalibrateRig(const calib::Rig& rig,
                            const CeilingKeyframes& spin,
                            const CeilingKeyframes& straight,
                            const TapeMeasures& tape,
                            double lens_sigma_px);

}  // namespace ceilmap::recordings
