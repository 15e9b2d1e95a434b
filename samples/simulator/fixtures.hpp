#pragma once

#include <vector>

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// All boxes of a scene: listed ones, beams and pillars, and random ones.
std::vector<Box> MakeFixtures(const Scene& scene);

}  // namespace ceilmap::simulator
