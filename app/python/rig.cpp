#include "app/python/rig.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "app/python/bindings.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/yaml_value.hpp"
#include "calib/nominal_rig.hpp"
#include "calib/robot_rig.hpp"

namespace ceilmap::python {
namespace {

using calib::Rig;
using Size = std::pair<int, int>;  // width, height

std::map<std::string, Size> CamerasOf(const Rig& rig) {
  std::map<std::string, Size> cameras;
  const auto add = [&cameras](const char* name, const std::optional<calib::MountedCamera>& camera) {
    if (camera) cameras[name] = {camera->camera.Size().width, camera->camera.Size().height};
  };
  add("up", rig.up);
  add("forward", rig.forward);
  add("omni", rig.omni);
  return cameras;
}

Rig Scaled(Rig rig, const std::string& camera, Size size) {
  static constexpr const char* kSource = "the images";
  const cv::Size images(size.first, size.second);
  if (camera == "up") {
    calib::FitUpCamera(rig, kSource, images);
  } else if (camera == "forward") {
    calib::FitForwardCamera(rig, kSource, images);
  } else if (camera == "omni") {
    calib::FitOmniCamera(rig, kSource, images);
  } else {
    throw InputError(fmt::format("camera '{}': must be up, forward or omni", camera));
  }
  return rig;
}

Rig Nominal(Size size, double fov_deg, double ceiling_height, double camera_height) {
  return calib::NominalRig({size.first, size.second},
                           {kRadPerDeg * fov_deg, ceiling_height, camera_height});
}

}  // namespace

Rig RigOf(const store::MapReader& map, const std::string& name) {
  const std::string text = map.Metadata().rig_yaml;
  if (text.empty()) throw InputError(fmt::format("{}: was made without a rig; give a Rig", name));
  if (text.size() > kMaxSettingsBytes) {
    throw InputError(fmt::format("{}: its rig is larger than 1 MiB; give a Rig", name));
  }
  return calib::ParseRig(text, name + " (its rig)");
}

void BindRig(py::module_& module) {
  py::class_<Rig>(module, "Rig", R"(The cameras and dimensions of a robot, as read from rig.yaml.

calib/README.md describes the file. The frame base is the foot of the camera mast on the floor: x
forward, y left, z up; metres and radians. A Rig does not change; scaled_to returns another one.)")
      .def_static("load",
                  &calib::ReadRig,
                  py::arg("path"),
                  "Reads rig.yaml. Raises InputError with file, line, key and how to fix it.")
      .def_static(
          "parse",
          [](const std::string& text) { return calib::ParseRig(text, "the rig"); },
          py::arg("text"),
          "The same from the text of such a file; a relative camera_info path starts at the\n"
          "current folder.")
      .def_static("nominal",
                  &Nominal,
                  py::arg("size"),
                  py::arg("fov_deg"),
                  py::arg("ceiling_height"),
                  py::arg("camera_height") = 0.0,
                  R"(A camera without calibration: straight up, without distortion.

size: (width, height) of the images. fov_deg: field of view across the width, degrees.
ceiling_height, camera_height: above the floor, metres; at 0 the ceiling's height is counted from
the camera.)")
      .def("scaled_to",
           &Scaled,
           py::arg("camera"),
           py::arg("size"),
           "The same robot whose camera ('up', 'forward', 'omni') gives images of another size,\n"
           "(width, height), of the same shape.")
      .def_readonly("robot", &Rig::robot, "Name of the robot.")
      .def_readonly("ceiling_height", &Rig::ceiling_height_m, "Above the floor, metres.")
      .def_readonly("axle_behind_mast",
                    &Rig::axle_behind_mast_m,
                    "The axle stands at x = -axle_behind_mast of base, metres.")
      .def_property_readonly(
          "cameras", &CamerasOf, "Size (width, height) of the images of each camera, by its name.")
      .def_readonly("yaml", &Rig::source_yaml, "The text of the file.")
      .def_readonly("assumed", &Rig::assumed, "Values that the file does not give, a line each.")
      .def("__repr__", [](const Rig& rig) {
        return fmt::format("<ceilmap.Rig '{}', ceiling {} m, {} cameras>",
                           rig.robot,
                           rig.ceiling_height_m,
                           CamerasOf(rig).size());
      });
}

}  // namespace ceilmap::python
