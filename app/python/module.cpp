#include "app/python/bindings.hpp"

namespace ceilmap::python {
namespace {

// Names in messages and in help(): ceilmap.Map, not ceilmap._ceilmap.Map.
void NameAsImported(const py::module_& module) {
  for (const auto& [name, value] : module.attr("__dict__").cast<py::dict>()) {
    if (PyType_Check(value.ptr()) != 0) value.attr("__module__") = "ceilmap";
  }
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): names of pybind11's macro
PYBIND11_MODULE(_ceilmap, module) {
  module.doc() = "The compiled part of the package ceilmap.";
  module.attr("__version__") = CEILMAP_VERSION;
  BindErrors(module);
  BindRegistration(module);
  BindRig(module);
  BindSettings(module);
  BindRobotTypes(module);
  BindSensors(module);
  BindMapper(module);
  BindLocalizer(module);
  BindMap(module);
  BindEvaluation(module);
  NameAsImported(module);
}

}  // namespace ceilmap::python
