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

/// All that `calibrate rig` found.
struct RigFindings {
  RigCalibration mount;
  std::optional<ForwardCalibration> forward;
};

/// The forward camera's angles that are not known well, with the recordings that determine them; a
/// line each.
std::vector<std::string> UncertainAngles(const RigFindings& found);

}  // namespace ceilmap::recordings
