#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "samples/simulator/path.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// A mover as it stands at one moment.
struct PaintedBox {
  Box box;           ///< its brightness is the colour's luminance
  cv::Vec3f colour;  ///< blue, green, red, of unit luminance
};

/// The movers that are in the room when a frame is taken.
std::vector<PaintedBox> MoversAt(const Scene& scene, const Frame& frame);

}  // namespace ceilmap::simulator
