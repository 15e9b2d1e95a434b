#include "app/python/bindings.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::python {

void BindErrors(py::module_& module) {
  py::register_exception<InputError>(module, "InputError", PyExc_ValueError).doc() =
      "A file, setting or argument that cannot be used. The text is one line that states what is\n"
      "wrong, where, and how to fix it: the line that the program prints before exit code 2.";
  py::register_exception<RunError>(module, "RunError", PyExc_RuntimeError).doc() =
      "The input was usable, but the work could not be done: no texture, disk full, ... The text\n"
      "is one line: the line that the program prints before exit code 1.";
}

}  // namespace ceilmap::python
