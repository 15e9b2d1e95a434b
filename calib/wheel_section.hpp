#pragma once

#include <string>
#include <utility>
#include <vector>

#include "calib/base/yaml_value.hpp"
#include "calib/wheels/wheel_model.hpp"

namespace ceilmap::calib {

/// Reads the section `wheels` of rig.yaml (format: calib/README.md). What it leaves out has the
/// values of a default WheelModel. @throws InputError with file and line.
wheels::WheelModel ParseWheels(const YamlValue& section);

/// The entries of such a section, as keys and numbers; a constant has its value and its standard
/// deviation.
std::vector<std::pair<std::string, std::vector<double>>> WheelEntries(
    const wheels::WheelModel& model);

}  // namespace ceilmap::calib
