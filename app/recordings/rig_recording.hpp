#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/recordings/frame_source.hpp"
#include "calib/base/twist2.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/rig.hpp"
#include "calib/solve/forward_mount.hpp"
#include "compensation/mount/ceiling_recording.hpp"

namespace ceilmap::recordings {

/// A recording of both cameras.
struct RigRecording {
  std::string up;
  std::string forward;           ///< empty: upward camera only
  std::filesystem::path stamps;  ///< of both; empty: the recordings' own time
  BagTopic up_topic = {};        ///< of those that are bags
  BagTopic forward_topic = {};
  /// Of base at some of the images, as far as they are known.
  std::vector<StampedTwist2> velocities = {};
};

/// Reads the upward camera's recording of a spin or of a straight drive.
/// @param view  of the upward camera as far as it is known. @param label  of the progress.
/// @throws InputError when the ceiling is lost for 5 consecutive frames.
mount::CeilingRecording ReadCeiling(FrameSource& source,
                                    const calib::CeilingView& view,
                                    const std::string& label);

/// What could be followed of a drive.
struct FollowedDrive {
  std::vector<mount::CeilingRecording> parts;  ///< with at least three keyframes each
  std::int64_t frames = 0;                     ///< read
  std::int64_t lost = 0;                       ///< matched no frame before them
};

/// Reads the upward camera's recording of any drive. Where the ceiling is lost for 3 consecutive
/// frames, a new part begins.
/// @param seconds  The end is ignored from this time on, if the recording has times.
FollowedDrive FollowDrive(FrameSource& source, const calib::CeilingView& view, double seconds);

/// Reads the recordings of both cameras: matches of the forward camera, with the robot's motion by
/// the upward camera. Prints warnings of the forward recording.
/// @param rig  With the calibrated upward camera and the approximate forward camera, both fitted to
/// the recordings (calib/robot_rig.hpp).
/// @param label  Of the progress.
/// @throws InputError when a source cannot be used, or the ceiling is lost for 5 consecutive
/// frames.
std::vector<calibration::MotionWithMatches> ReadForwardMatches(const RigRecording& recording,
                                                               const calib::Rig& rig,
                                                               const std::string& label);

}  // namespace ceilmap::recordings
