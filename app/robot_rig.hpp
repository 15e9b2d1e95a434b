#pragma once

#include <filesystem>

#include "app/frame_source.hpp"
#include "calib/rig.hpp"

namespace ceilmap::app {

/// The rig's upward camera, if a recording can come from it.
/// @param file  of the rig, for messages.
/// @throws calib::InputError when the rig has none, or its pictures have another size.
const calib::MountedCamera& UpCameraOf(const calib::Rig& rig,
                                       const std::filesystem::path& file,
                                       const FrameSource& source);

}  // namespace ceilmap::app
