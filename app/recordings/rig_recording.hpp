#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/rig.hpp"
#include "calib/solve/forward_mount.hpp"

namespace ceilmap::recordings {

/// A recording of both cameras.
struct RigRecording {
  std::string up;
  std::string forward;           ///< empty: upward camera only
  std::filesystem::path stamps;  ///< of both; empty: the recordings' own time
};

/// The robot's motion in space, from one recording.
struct RigMotion {
  /// Of each frame, relative to the first, which is level; nothing: not measured.
  std::vector<std::optional<Eigen::Isometry3d>> T_first_base;
  std::vector<calibration::MotionWithMatches> forward_pairs;  ///< of the forward camera
  std::int64_t frames = 0;
};

/// Tracks a recording by the ceiling, and the features of the forward camera.
/// @param rig  With the calibrated upward camera and the approximate forward camera.
/// @param label  Of the progress.
/// @throws InputError when a source cannot be used, the forward camera is not in the rig, or
/// tracking is lost for longer than a moment.
RigMotion ReadMotion(const RigRecording& recording,
                     const calib::Rig& rig,
                     const std::string& label);

}  // namespace ceilmap::recordings
