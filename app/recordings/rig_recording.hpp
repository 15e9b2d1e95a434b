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
  std::string forward;           ///< empty: of the upward camera alone
  std::filesystem::path stamps;  ///< of both; empty: the recordings' own time
};

/// What a recording shows of the robot's motion in space.
struct RigMotion {
  /// Of each frame, the first being level; nothing: the ceiling did not tell.
  std::vector<std::optional<Eigen::Isometry3d>> T_first_base;
  std::vector<calibration::MotionWithMatches> forward_pairs;  ///< of the forward camera
  std::int64_t frames = 0;
};

/// Follows a recording by the ceiling, and what the forward camera shows on the way.
/// @param rig  its upward camera as calibrated, its forward one as far as it is known.
/// @param label  of the progress.
/// @throws InputError when a source cannot be used, the forward camera is not in the rig, or
///   the ceiling is lost for longer than a moment.
RigMotion ReadMotion(const RigRecording& recording,
                     const calib::Rig& rig,
                     const std::string& label);

}  // namespace ceilmap::recordings
