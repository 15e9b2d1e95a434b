#pragma once

/// Interface for a robot's program: mapping of the ceiling, and localization on a map.

#include "calib/rig.hpp"
#include "calib/robot_rig.hpp"
#include "localization/robot/ceiling_localizer.hpp"
#include "localization/robot/ceiling_mapper.hpp"
