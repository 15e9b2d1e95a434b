#pragma once

#include <string>

#include "samples/simulator/path.hpp"

namespace ceilmap::simulator {

/// @param source  Of the pose: the file or the key at fault.
/// @throws InputError `SOURCE: at TIME s the camera at ... must be inside of the room ...` when a
/// camera of the robot is not inside the room at frame.T_map_base.
void CheckCamerasInside(const Scene& scene, const Frame& frame, const std::string& source);

}  // namespace ceilmap::simulator
