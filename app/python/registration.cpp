#include <pybind11/stl.h>

#include <optional>

#include "app/python/arrays.hpp"
#include "app/python/bindings.hpp"
#include "calib/base/error.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::python {
namespace {

using registration::Registration;

// A registration with the size of its images, about whose centre the motion is.
struct Found {
  Registration registration;
  cv::Size size;

  // Nothing is guessed: without an answer there is no value.
  template <typename Get>
  auto IfOk(const Get& get) const -> std::optional<decltype(get(registration))> {
    if (!registration.ok()) return std::nullopt;
    return get(registration);
  }
  [[nodiscard]] std::optional<py::array> Matrix() const {
    if (!registration.ok()) return std::nullopt;
    const Eigen::Vector2d centre(0.5 * (size.width - 1), 0.5 * (size.height - 1));
    Eigen::Matrix<double, 2, 3> matrix;
    matrix.col(2) = registration.motion.Apply(-centre) + centre;
    matrix.col(0) =
        registration.motion.Apply(Eigen::Vector2d::UnitX() - centre) + centre - matrix.col(2);
    matrix.col(1) =
        registration.motion.Apply(Eigen::Vector2d::UnitY() - centre) + centre - matrix.col(2);
    return ToArray(matrix);
  }
};

Found Register(const py::array& reference_array,
               const py::array& current_array,
               bool fixed_scale,
               const std::optional<py::array>& mask_array) {
  const cv::Mat reference = ImageView(reference_array, "reference");
  const cv::Mat current = ImageView(current_array, "current");
  if (reference.size() != current.size()) {
    throw InputError("reference and current: must have one shape");
  }
  registration::RegistrarParams params;
  params.estimate_scale = !fixed_scale;
  params.local_features = true;
  if (mask_array) {
    params.mask = ImageView(*mask_array, "mask");
    if (params.mask.size() != reference.size()) {
      throw InputError("mask: must have the shape of the images");
    }
  }
  const py::gil_scoped_release unlocked;
  registration::Registrar registrar(reference.size(), params);
  return {registrar.RegisterAnyPlaces(registrar.Analyze(reference), registrar.Analyze(current)),
          reference.size()};
}

constexpr const char* kRegistrationDoc =
    R"(The motion between two images, as `ceilmap register` finds it:

    x' = s R(theta) (x - c) + c + t,   c = ((width - 1) / 2, (height - 1) / 2)

takes a pixel x = (column, row) of the reference to the pixel x' of the current image that shows
the same point. Rows point down, so theta > 0 turns the content clockwise on the screen.
tx, ty, theta, scale, covariance and matrix are None without an answer (ok is False).
A registration is true where ok is.)";

constexpr const char* kRegisterDoc =
    R"(Finds the motion between two images of one size, without any prior knowledge.

reference, current: uint8 arrays of shape (height, width), each side 96 to 16384 px. They are not
    copied; a part of a larger image may be passed.
fixed_scale: True: the images have the same scale (a level robot). False: it is 0.7 to 1.4.
mask: like the images, 0 where neither has content; None: they have content everywhere.

The content of the images never raises an error: see Registration.verdict. Other threads of Python
run meanwhile.)";

}  // namespace

void BindRegistration(py::module_& module) {
  py::class_<Found> found(module, "Registration", kRegistrationDoc);
  const auto add = [&found](const char* name, const char* doc, const auto& get) {
    found.def_property_readonly(
        name, [get](const Found& self) { return get(self.registration); }, doc);
  };
  const auto add_if_ok = [&found](const char* name, const char* doc, const auto& get) {
    found.def_property_readonly(
        name, [get](const Found& self) { return self.IfOk(get); }, doc);
  };
  using R = Registration;
  add("ok", "One motion explains the images, and no other does nearly as well.", [](const R& r) {
    return r.ok();
  });
  add("verdict", "'ok', 'no texture', 'no match' or 'ambiguous'.", [](const R& r) {
    return registration::ToString(r.verdict);
  });
  add_if_ok("tx", "Pixels to the right.", [](const R& r) { return r.motion.tx_px; });
  add_if_ok("ty", "Pixels down.", [](const R& r) { return r.motion.ty_px; });
  add_if_ok("theta", "Radians in (-pi, pi], clockwise on the screen.", [](const R& r) {
    return r.motion.theta_rad;
  });
  add_if_ok("scale", "Factor, > 0.", [](const R& r) { return r.motion.scale; });
  add_if_ok("covariance",
            "(4, 4): of (tx, ty, theta, ln scale); zero for a fixed scale.",
            [](const R& r) { return ToArray(r.covariance); });
  found.def_property_readonly(
      "matrix",
      &Found::Matrix,
      "(2, 3): x' = matrix @ (column, row, 1), as cv2.warpAffine takes it.");
  add("peak", "Agreement of the images under the motion, 0 to 1.", [](const R& r) {
    return r.peak;
  });
  add("runner_up", "The same of the best different motion, 0 to 1.", [](const R& r) {
    return r.runner_up;
  });
  add("overlap", "Fraction of the reference in view of the current image, 0 to 1.", [](const R& r) {
    return r.overlap;
  });
  add("blocks", "Blocks that could be compared.", [](const R& r) { return r.blocks; });
  add("inliers", "Those that agree with the motion.", [](const R& r) { return r.inliers; });
  found.def("__bool__", [](const Found& self) { return self.registration.ok(); });
  module.def("register",
             &Register,
             py::arg("reference"),
             py::arg("current"),
             py::kw_only(),
             py::arg("fixed_scale") = false,
             py::arg("mask") = py::none(),
             kRegisterDoc);
}

}  // namespace ceilmap::python
