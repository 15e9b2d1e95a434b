#pragma once

#include <array>
#include <vector>

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// Points x, y of a polyline in map, metres.
using Points = std::vector<std::array<double, 2>>;

/// The corners of the axle's drive, at least two. @param scene  Valid, not of PathKind::kTum.
Points PathPoints(const Scene& scene);

}  // namespace ceilmap::simulator
