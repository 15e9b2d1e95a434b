#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "app/recordings/frame_source.hpp"
#include "calib/rig.hpp"

namespace ceilmap::recordings {

/// The rig's upward camera, if a recording can come from it.
/// @param file  of the rig, for messages.
/// @throws InputError when the rig has none, or its images have another size.
const calib::MountedCamera& UpCameraOf(const calib::Rig& rig,
                                       const std::filesystem::path& file,
                                       const FrameSource& source);

/// The rig's mirror camera, likewise.
const calib::MountedCamera& OmniCameraOf(const calib::Rig& rig,
                                         const std::filesystem::path& file,
                                         const FrameSource& source);

/// Checks that a recording can come from the rig's forward camera; otherwise as UpCameraOf.
void CheckForwardCamera(const calib::Rig& rig,
                        const std::filesystem::path& file,
                        const std::string& source,
                        cv::Size size);

}  // namespace ceilmap::recordings
