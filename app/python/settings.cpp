#include "app/python/settings.hpp"

#include <pybind11/stl/filesystem.h>

#include <string>
#include <variant>

#include "app/python/bindings.hpp"
#include "localization/compass/colour/colour_settings.hpp"
#include "localization/compass/labrosse/compass_settings.hpp"
#include "localization/localizer_settings.hpp"
#include "localization/robot/sensor_settings.hpp"
#include "mapping/mapper_settings.hpp"

namespace ceilmap::python {
namespace {

py::dict DefaultSettings() {
  ModuleSettings defaults;
  const Settings settings = defaults.Describe();
  py::dict sections;
  for (const Setting& setting : settings.List()) {
    py::dict section = sections;
    std::size_t start = 0;
    for (std::size_t dot = setting.key.find('.'); dot != std::string::npos;
         dot = setting.key.find('.', start)) {
      const py::str name(setting.key.substr(start, dot - start));
      if (!section.contains(name)) section[name] = py::dict();
      section = section[name].cast<py::dict>();
      start = dot + 1;
    }
    const py::str name(setting.key.substr(start));
    std::visit([&](const auto& value) { section[name] = py::cast(value); }, setting.get());
  }
  return sections;
}

}  // namespace

Settings ModuleSettings::Describe() {
  Settings settings;
  mapping::Describe(mapping, settings.In("mapping"));
  robot::Describe(sensors, settings.In("sensors"));
  localization::Describe(localization, settings.In("localization"));
  labrosse::Describe(compass, settings.In("compass"));
  colour::Describe(colour_learn, settings.In("colour_learn"));
  colour::Describe(colour_compass, settings.In("colour_compass"));
  return settings;
}

ModuleSettings ReadSettings(const py::object& settings) {
  ModuleSettings params;
  if (settings.is_none()) return params;
  if (py::isinstance<py::dict>(settings)) {
    if (py::len(settings) == 0) return params;
    // A text in JSON is one in YAML.
    const py::object text = py::module_::import("json").attr("dumps")(settings);
    params.Describe().Parse(text.cast<std::string>(), "settings");
  } else {
    params.Describe().Load(settings.cast<std::filesystem::path>());
  }
  return params;
}

void BindSettings(py::module_& module) {
  module.def("default_settings",
             &DefaultSettings,
             R"(The parameters of all methods as a dict of sections, with their defaults.

`ceilmap settings` prints units, ranges and meaning. CeilingMapper uses the sections 'mapping' and
'sensors', CeilingLocalizer 'localization' and 'sensors'. Their argument `settings` takes a dict of
this form that may leave out what stays as it is, or the path of a YAML file.)");
}

}  // namespace ceilmap::python
