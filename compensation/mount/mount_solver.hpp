#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "calib/rig.hpp"
#include "calib/solve/rig_solver.hpp"
#include "compensation/mount/ceiling_recording.hpp"
#include "compensation/mount/up_mount.hpp"

namespace ceilmap::mount {

/// Poses of the levelled camera at the keyframes, as the recording was followed.
std::vector<Pose2> KeyframePoses(const CeilingRecording& recording);

/// The rotation of a mount: p_base = R p_cam.
Eigen::Matrix3d RotationOf(const calibration::RigMount& mount);

/// The mount in units of the ceiling's distance, and the read-out time, from keyframes of a turn on
/// the spot and of a straight drive.
struct SolvedMount {
  calibration::RigSolution solution;
  ReadoutFinding readout;
  /// Velocities of the levelled camera at the keyframes of both recordings.
  std::array<std::vector<calibration::ViewVelocity>, 2> velocities;
};

/// Alternates the measurement of pairs of images and the fit of the mount to them until the mount
/// does not change. A camera whose read-out time cannot be told from 0, or not at all, is solved
/// again with a known one: the mount is then more accurate.
/// @param rig  See MeasureUpMount. @throws InputError when the ceiling has too little texture.
SolvedMount SolveMount(const calib::Rig& rig,
                       const CeilingRecording& spin,
                       const CeilingRecording& straight,
                       double lens_sigma_px);

}  // namespace ceilmap::mount
