#pragma once

/// All that a robot's program needs to map the ceiling and to find its way by it.

#include "calib/rig.hpp"
#include "localization/robot/ceiling_localizer.hpp"
#include "localization/robot/ceiling_mapper.hpp"
