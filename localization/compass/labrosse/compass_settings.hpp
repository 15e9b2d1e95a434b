#pragma once

#include "calib/base/settings.hpp"
#include "localization/compass/labrosse/methods.hpp"

namespace ceilmap::labrosse {

/// What a settings file can set of the compasses by panoramas.
void Describe(CompassParams& params, const Settings& settings);

}  // namespace ceilmap::labrosse
