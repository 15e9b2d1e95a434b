#pragma once

#include <vector>

#include "samples/simulator/path.hpp"

namespace ceilmap::simulator {

/// One frame for each line `timestamp tx ty tz qx qy qz qw` of scene.path.tum_file, at most
/// path.max_frames. Between the lines the robot moves evenly.
/// @throws calib::InputError `FILE:LINE: ...` for a line that is not a pose, stamps that do not
///   rise, and a pose whose camera is not inside of the room.
std::vector<Frame> TumFrames(const Scene& scene);

}  // namespace ceilmap::simulator
