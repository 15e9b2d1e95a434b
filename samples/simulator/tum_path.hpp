#pragma once

#include <vector>

#include "samples/simulator/path.hpp"

namespace ceilmap::simulator {

/// @throws InputError naming path.tum_file when there are no poses.
void CheckPosesRead(const Path& path);

/// One frame for each pose of scene.path.poses, at most path.max_frames. Between them the velocity
/// is constant.
/// @throws InputError naming path.tum_file when there are no poses, stamps do not increase, or a
/// pose's camera is not inside the room.
std::vector<Frame> TumFrames(const Scene& scene);

}  // namespace ceilmap::simulator
