#pragma once

#include "calib/base/settings.hpp"
#include "compensation/tilt_estimator.hpp"

namespace ceilmap::compensation {

/// What a settings file can set of the measurement of tilt.
void Describe(TiltEstimatorParams& params, const Settings& settings);

}  // namespace ceilmap::compensation
