#pragma once

#include <vector>

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// All boxes of a scene: those listed, beams and pillars, and those drawn from the seed.
std::vector<Box> MakeFixtures(const Scene& scene);

}  // namespace ceilmap::simulator
