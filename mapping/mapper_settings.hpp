#pragma once

#include "calib/base/settings.hpp"
#include "mapping/mapper.hpp"

namespace ceilmap::mapping {

/// What a settings file can set of the mapper.
void Describe(MapperParams& params, const Settings& settings);

}  // namespace ceilmap::mapping
