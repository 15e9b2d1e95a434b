#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <vector>

#include "localization/localizer.hpp"
#include "localization/robot/sensors.hpp"
#include "mapping/mapper.hpp"

/// Results of the mapper and the localizer as Python's types.
namespace ceilmap::python {

namespace py = pybind11;

/// Counts and figures by name.
py::dict ToDict(const mapping::MapperReport& report);
py::dict ToDict(const localization::LocalizerReport& report);
py::dict ToDict(const robot::SensorsReport& report);
py::dict ToDict(const graph::MapQuality& quality);

/// A structured array: kind, keyframe, x, y, extent.
py::array ToTable(const std::vector<graph::WeakSpot>& spots);

}  // namespace ceilmap::python
