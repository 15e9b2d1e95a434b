#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/recordings/rig_calibration.hpp"
#include "app/recordings/rig_recording.hpp"
#include "calib/rig.hpp"
#include "calib/solve/forward_mount.hpp"
#include "calib/solve/pivot_fit.hpp"

namespace ceilmap::recordings {

/// How the forward camera is turned: p_base = Rz(yaw) Ry(-pitch) Rx(roll) p_level, of a level
/// camera that looks along base x. Pitch > 0 is raised. An angle that the recordings do not tell
/// has a large deviation and stays as it was.
struct ForwardCalibration {
  Measured yaw_rad;
  Measured pitch_rad;
  Measured roll_rad;
  Eigen::Isometry3d T_base_forward = Eigen::Isometry3d::Identity();
  calibration::ForwardMount mount;
  std::size_t pairs = 0;  ///< of moments
};

/// What a recording over a step tells.
struct StepCalibration {
  std::vector<calibration::Climb> climbs;  ///< of the frames whose tilt the ceiling showed
  calibration::PivotFit pivots;
  double max_pitch_rad = 0;  ///< to either side
  /// The robot stands level and higher at the end: all wheels are on the step.
  std::optional<Measured> climbed_m;
  std::optional<double> height_m;  ///< of the step, as given
  /// How far the wheels that climb first are from the axle, by that height.
  std::optional<Measured> wheelbase_m;
};

/// Angles of a forward camera, see ForwardCalibration.
struct ForwardAngles {
  double yaw_rad = 0;
  double pitch_rad = 0;
  double roll_rad = 0;
};
ForwardAngles ForwardAnglesOf(const Eigen::Matrix3d& R_base_cam);

/// @param motions  of recordings with a forward camera. @param mount  of the upward camera: what is
///   wrong with it is wrong with the motions.
/// @throws InputError when they show too little, or it does not agree.
ForwardCalibration CalibrateForward(const calib::Rig& rig,
                                    const std::vector<RigMotion>& motions,
                                    const std::string& source,
                                    const RigCalibration& mount,
                                    double lens_sigma_px);

/// @param height_m  of the step, where it was measured. @param lens_sigma_px  as SolveRig's: what
/// the
///   intrinsics put wrong at the image's edge passes for a lift, and for a tilt.
/// @throws InputError when the robot does not climb.
StepCalibration CalibrateStep(const RigMotion& motion,
                              const std::string& source,
                              const RigCalibration& mount,
                              const calib::PinholeCamera& up,
                              std::optional<double> height_m,
                              double lens_sigma_px);

/// All that `calibrate rig` found.
struct RigFindings {
  RigCalibration mount;
  std::optional<ForwardCalibration> forward;
  std::optional<StepCalibration> step;
};

/// What does not fit together, or is not known well, with what to do; a line each.
/// @param step  the recording's name.
std::vector<std::string> Contradictions(const RigFindings& found, const std::string& step);

}  // namespace ceilmap::recordings
