#pragma once

#include <pybind11/pybind11.h>

#include "calib/base/settings.hpp"
#include "localization/compass/colour/colour_compass.hpp"
#include "localization/compass/colour/colour_learner.hpp"
#include "localization/compass/labrosse/methods.hpp"
#include "localization/localizer.hpp"
#include "localization/robot/sensors.hpp"
#include "mapping/mapper.hpp"

namespace ceilmap::python {

namespace py = pybind11;

/// All parameters that a settings file of the program can set, so that one file serves both. The
/// module uses the first three.
struct ModuleSettings {
  mapping::MapperParams mapping;
  robot::SensorsParams sensors;
  localization::LocalizerParams localization;
  labrosse::CompassParams compass;
  colour::LearnParams colour_learn;
  colour::ColourCompassParams colour_compass;

  /// The keys that refer to this object, which must outlive them.
  Settings Describe();
};

/// @param settings  None: the defaults; a dict of sections, or the path of a YAML file.
/// @throws InputError as Settings::Load. A dict is called "settings" in messages.
ModuleSettings ReadSettings(const py::object& settings);

}  // namespace ceilmap::python
