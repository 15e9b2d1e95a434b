#pragma once

#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/rig.hpp"
#include "calib/solve/rig_solver.hpp"
#include "compensation/mount/ceiling_recording.hpp"

namespace ceilmap::mount {

/// Ceiling points that two keyframes show, for many pairs: consecutive keyframes, and keyframes
/// farther apart as long as they overlap by at least 35 %.
/// @param up  the camera as far as it is known.
/// @param cameras  poses of the keyframes' cameras as far as they are known.
/// @param accurate  camera and poses are known to one or two pixels over the image. Otherwise the
///   motion of each pair is refined first, tilt included.
calibration::Recording MeasurePairs(const CeilingRecording& recording,
                                    const calib::MountedCamera& up,
                                    double ceiling_height_m,
                                    const std::vector<Pose2>& cameras,
                                    bool accurate);

}  // namespace ceilmap::mount
