#pragma once

#include <optional>

#include "calib/base/heading.hpp"
#include "calib/base/tilt.hpp"

namespace ceilmap::mapping {

/// What is known of a frame besides its image.
struct FrameContext {
  Tilt tilt = {};  ///< how the robot stood; level where that is not known
  /// Of a compass or wheels, all of one source: only turns between frames are used.
  std::optional<HeadingPrior> heading = std::nullopt;
};

}  // namespace ceilmap::mapping
