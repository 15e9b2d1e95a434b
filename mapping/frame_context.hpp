#pragma once

#include <optional>

#include "calib/base/heading.hpp"
#include "calib/base/tilt.hpp"
#include "calib/wheels/relative_motion.hpp"
#include "mapping/registration/encoding.hpp"

namespace ceilmap::mapping {

/// Information about a frame other than its image.
struct FrameContext {
  Tilt tilt = {};  ///< tilt of the robot; level where it is unknown
  /// Heading from a compass or from wheel odometry. All headings of a recording come from one
  /// source: only turns between frames are used.
  std::optional<HeadingPrior> heading = std::nullopt;
  /// Share of the image that repeats the one before (RepetitionMeter), 0..1.
  double repeated = 0;
  /// Of the image, where it is not analysed already.
  registration::Encoding encoding = {};
  /// Motion of the robot since the frame before, by its wheels.
  std::optional<wheels::RelativeMotion> wheels = std::nullopt;
};

}  // namespace ceilmap::mapping
