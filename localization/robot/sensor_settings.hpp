#pragma once

#include "calib/base/settings.hpp"
#include "localization/robot/sensors.hpp"

namespace ceilmap::robot {

/// What a settings file can set of the sensors beside the upward camera.
void Describe(SensorsParams& params, const Settings& settings);

}  // namespace ceilmap::robot
