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

/// Orientation of the forward camera: p_base = Rz(yaw) Ry(-pitch) Rx(roll) p_level, of a level
/// camera that points along base x. Pitch > 0 is raised. An angle that the recordings do not
/// determine has a large standard deviation and is not changed.
struct ForwardCalibration {
  Measured yaw_rad;
  Measured pitch_rad;
  Measured roll_rad;
  Eigen::Isometry3d T_base_forward = Eigen::Isometry3d::Identity();
  calibration::ForwardMount mount;
  std::size_t pairs = 0;  ///< number of image pairs
};

/// Result of a recording over a step.
struct StepCalibration {
  std::vector<calibration::Climb> climbs;  ///< of the frames whose tilt was measured by the ceiling
  calibration::PivotFit pivots;
  double max_pitch_rad = 0;  ///< in either direction
  /// The robot is level and higher at the end: all wheels are on the step.
  std::optional<Measured> climbed_m;
  std::optional<double> height_m;  ///< of the step, as given
  /// Distance of the wheels that climb first from the axle, by that height.
  std::optional<Measured> wheelbase_m;
};

/// Angles of a forward camera, see ForwardCalibration.
struct ForwardAngles {
  double yaw_rad = 0;
  double pitch_rad = 0;
  double roll_rad = 0;
};
ForwardAngles ForwardAnglesOf(const Eigen::Matrix3d& R_base_cam);

/// @param motions  Of recordings with a forward camera. @param mount  Of the upward camera: its
/// errors are errors of the motions.
/// @throws InputError when there are too few matches, or they do not agree.
ForwardCalibration CalibrateForward(const calib::Rig& rig,
                                    const std::vector<RigMotion>& motions,
                                    const std::string& source,
                                    const RigCalibration& mount,
                                    double lens_sigma_px);

/// @param height_m  Of the step, if measured. @param lens_sigma_px  As for SolveRig: an error of
/// the intrinsics at the image's edge has the effect of a lift and of a tilt.
/// @throws InputError when the robot does not climb.
StepCalibration CalibrateStep(const RigMotion& motion,
                              const std::string& source,
                              const RigCalibration& mount,
                              const calib::PinholeCamera& up,
                              std::optional<double> height_m,
                              double lens_sigma_px);

/// All results of `calibrate rig`.
struct RigFindings {
  RigCalibration mount;
  std::optional<ForwardCalibration> forward;
  std::optional<StepCalibration> step;
};

/// Contradictions and inaccurate values, each with a solution; one line each.
/// @param step  Name of the recording.
std::vector<std::string> Contradictions(const RigFindings& found, const std::string& step);

}  // namespace ceilmap::recordings
