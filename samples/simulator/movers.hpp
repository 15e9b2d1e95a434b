#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "samples/simulator/solid.hpp"

namespace ceilmap::simulator {

/// A mover at one moment.
struct PaintedSolid {
  Solid solid;       ///< its brightness is the colour's luminance
  cv::Vec3f colour;  ///< blue, green, red, of unit luminance
};

/// The movers and the moving structures at the time of a frame. @param shift_s  Of the moving
/// structures, from the middle of the exposure.
std::vector<PaintedSolid> MoversAt(const Scene& scene, double stamp_s, double shift_s = 0);

}  // namespace ceilmap::simulator
