#pragma once

#include <pybind11/pybind11.h>

/// The Python module `ceilmap._ceilmap`: one function for each area adds its classes and functions.
/// Python code sees metres, seconds and radians; sizes of images are (width, height), their arrays
/// have the shape (height, width) or (height, width, 3).
namespace ceilmap::python {

namespace py = pybind11;

void BindErrors(py::module_& module);
void BindRegistration(py::module_& module);
void BindRig(py::module_& module);
void BindSettings(py::module_& module);
void BindRobotTypes(py::module_& module);  ///< Estimate, MappingResult
void BindSensors(py::module_& module);
void BindMapper(py::module_& module);     ///< after BindSensors, BindRig and BindRobotTypes
void BindLocalizer(py::module_& module);  ///< likewise
void BindMap(py::module_& module);        ///< after BindRig
void BindEvaluation(py::module_& module);

}  // namespace ceilmap::python
