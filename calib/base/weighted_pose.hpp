#pragma once

#include "calib/base/pose2.hpp"

namespace ceilmap {

/// One of several possible poses.
struct WeightedPose {
  Pose2 pose;
  double weight = 1;  ///< > 0
};

}  // namespace ceilmap
