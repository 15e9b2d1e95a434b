#pragma once

#include "calib/base/settings.hpp"
#include "localization/localizer.hpp"

namespace ceilmap::localization {

/// What a settings file can set of the localizer.
void Describe(LocalizerParams& params, const Settings& settings);

}  // namespace ceilmap::localization
