#pragma once

#include <optional>

#include "calib/heading.hpp"
#include "calib/tilt.hpp"

namespace ceilmap::mapping {

/// What is known of a frame besides its picture.
struct FrameContext {
  calib::Tilt tilt = {};  ///< how the robot stood; level where that is not known
  /// Of a compass or wheels, all of one source: only turns between frames are used.
  std::optional<calib::HeadingPrior> heading = std::nullopt;
};

}  // namespace ceilmap::mapping
