#pragma once

#include "samples/simulator/solid.hpp"

namespace ceilmap::simulator {

/// Everything that stands still between floor and ceiling: the boxes of the fixtures (listed ones,
/// beams and pillars, random ones) and the structures. Known points are numbered by their name:
/// `duct-1`, `duct-2`, ...
Objects MakeObjects(const Scene& scene);

}  // namespace ceilmap::simulator
