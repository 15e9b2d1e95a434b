#pragma once

#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/rig.hpp"
#include "compensation/mount/ceiling_recording.hpp"

namespace ceilmap::mount {

/// The recording without the bands that lamps on the mains draw into the rows of a rolling shutter
/// (compensation::FlickerBands), of all images: bands of the first ones are those found later.
/// Unchanged where there are none, without stamps, and where the camera has no read-out time.
/// @param cameras  T_first_camera of the keyframes as far as they are known, in units of the
///   ceiling's distance. @param up  the camera as far as it is known.
CeilingRecording WithoutFlicker(const CeilingRecording& recording,
                                const std::vector<Pose2>& cameras,
                                const calib::MountedCamera& up,
                                double ceiling_height_m);

}  // namespace ceilmap::mount
