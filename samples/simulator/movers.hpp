#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "samples/simulator/path.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// A mover at one moment.
struct PaintedBox {
  Box box;           ///< its brightness is the colour's luminance
  cv::Vec3f colour;  ///< blue, green, red, of unit luminance
};

/// The movers in the room at the time of a frame.
std::vector<PaintedBox> MoversAt(const Scene& scene, const Frame& frame);

}  // namespace ceilmap::simulator
