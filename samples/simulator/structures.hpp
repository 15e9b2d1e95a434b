#pragma once

#include <vector>

#include "samples/simulator/solid.hpp"

namespace ceilmap::simulator {

/// Adds the structures that stand still, with their known points.
void AddStructures(const Scene& scene, Objects& objects);

/// The structures that move (fans, cranes) at a time after the start of the path.
std::vector<Solid> MovingStructures(const Scene& scene, double now_s);

/// Height above the floor at which the upward camera's images move fastest: that of the lowest
/// structure above the camera, or of the ceiling.
double NearestHeight(const Scene& scene);

/// Largest motion of a moving structure in an upward camera's image, pixels.
double MovingBlurLength(const Scene& scene, const Camera& camera);

/// Upper bound of the number of solids of a structure.
double CountSolids(const Structure& structure, const Room& room);

}  // namespace ceilmap::simulator
