#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "app/python/bindings.hpp"
#include "app/python/rig.hpp"
#include "app/python/robot_object.hpp"
#include "app/python/robot_types.hpp"
#include "app/python/settings.hpp"
#include "calib/base/degrees.hpp"
#include "localization/robot/ceiling_localizer.hpp"

namespace ceilmap::python {
namespace {

// With the standard deviations that `ceilmap localize --start` assumes.
std::optional<PoseWithCovariance> ToStart(const std::optional<PoseNumbers>& pose,
                                          const std::optional<py::array>& covariance) {
  constexpr double kPositionSigma = 0.5;
  constexpr double kYawSigma = 10 * kRadPerDeg;
  if (!pose) {
    if (covariance) throw InputError("start_covariance: give start too");
    return std::nullopt;
  }
  PoseWithCovariance start{ToPose(*pose, "start")};
  if (covariance) {
    start.covariance = ToCovariance(*covariance, "start_covariance");
  } else {
    const double position = kPositionSigma * kPositionSigma;
    start.covariance.diagonal() << position, position, kYawSigma * kYawSigma;
  }
  return start;
}

class PyLocalizer : public SharedRobot {
 public:
  PyLocalizer(const std::filesystem::path& map,
              const calib::Rig& rig,
              const robot::CeilingLocalizerParams& params)
      : localizer_(map, rig, params) {}

  template <typename Work>
  auto RunLocalizer(const Work& work) {
    return Run([&](robot::Sensors&) { return work(localizer_); });
  }

 private:
  robot::Sensors& Sensors() override { return localizer_; }

  robot::CeilingLocalizer localizer_;
};

std::unique_ptr<PyLocalizer> MakeLocalizer(
    const std::filesystem::path& map,
    const std::optional<calib::Rig>& rig,
    const std::optional<PoseNumbers>& start,
    const std::optional<py::array>& start_covariance,
    const std::optional<std::string>& tilt,
    const std::optional<std::filesystem::path>& heading_model,
    const py::object& settings) {
  const ModuleSettings read = ReadSettings(settings);
  robot::CeilingLocalizerParams params;
  params.sensors = read.sensors;
  params.localization = read.localization;
  params.localization.start = ToStart(start, start_covariance);
  const py::gil_scoped_release unlocked;
  const calib::Rig own = rig ? *rig : RigOf(store::MapReader(map), map.string());
  SensorArguments{tilt, heading_model}.Apply(&own, params.sensors);
  return std::make_unique<PyLocalizer>(map, own, params);
}

constexpr const char* kLocalizerDoc =
    R"(Finds and follows a robot on a map of the ceiling, switched on anywhere.

    localizer = ceilmap.CeilingLocalizer("lab.gpkg", ceilmap.Rig.load("rig.yaml"))
    for stamp, image in camera:
        estimate = localizer.add_ceiling(image, stamp)
        if estimate:
            x, y, yaw = estimate.pose)";

constexpr const char* kLocalizerInitDoc =
    R"(map: a map that was made with a rig.
rig: of this robot; None: it is the robot that made the map.
start: (x, y, yaw) of the first image; None: anywhere on the map.
start_covariance: (3, 3) of start; None: standard deviations of 0.5 m and 10 degrees.
tilt, heading_model, settings: as CeilingMapper.)";

}  // namespace

void BindLocalizer(py::module_& module) {
  py::class_<PyLocalizer, SharedRobot> localizer(module, "CeilingLocalizer", kLocalizerDoc);
  localizer.def(py::init(&MakeLocalizer),
                py::arg("map"),
                py::arg("rig") = py::none(),
                py::kw_only(),
                py::arg("start") = py::none(),
                py::arg("start_covariance") = py::none(),
                py::arg("tilt") = py::none(),
                py::arg("heading_model") = py::none(),
                py::arg("settings") = py::none(),
                kLocalizerInitDoc);
  BindCeiling<PyLocalizer, robot::CeilingLocalizer>(localizer);
  localizer
      .def(
          "restart",
          [](PyLocalizer& self,
             const std::optional<PoseNumbers>& start,
             const std::optional<py::array>& start_covariance) {
            const auto pose = ToStart(start, start_covariance);
            self.RunLocalizer([&](robot::CeilingLocalizer& l) { l.Restart(pose); });
          },
          py::arg("start") = py::none(),
          py::arg("start_covariance") = py::none(),
          "Discards the pose: the robot was carried away. It is searched for near start, or\n"
          "anywhere.")
      .def_property_readonly(
          "report",
          [](PyLocalizer& self) {
            return ToDict(self.RunLocalizer([](robot::CeilingLocalizer& l) { return l.Report(); }));
          },
          "Counts of images by status, and the scale of the ceiling against the rig.");
}

}  // namespace ceilmap::python
