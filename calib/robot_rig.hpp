#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "calib/rig.hpp"

namespace ceilmap::calib {

/// The rig's camera for a recording. Each checks that the rig has the camera and that its images
/// have the size of the recording's.
/// @param source  name of the recording, for messages. @param size  of its images.
/// @throws InputError otherwise.
const MountedCamera& UpCameraFor(const Rig& rig, const std::string& source, cv::Size size);
const MountedCamera& ForwardCameraFor(const Rig& rig, const std::string& source, cv::Size size);
const MountedCamera& OmniCameraFor(const Rig& rig, const std::string& source, cv::Size size);

}  // namespace ceilmap::calib
