#pragma once

#include "calib/base/settings.hpp"
#include "localization/compass/colour/colour_compass.hpp"
#include "localization/compass/colour/colour_learner.hpp"

namespace ceilmap::colour {

/// What a settings file can set of the learner and of the compass by colours.
void Describe(LearnParams& params, const Settings& settings);
void Describe(ColourCompassParams& params, const Settings& settings);

}  // namespace ceilmap::colour
