#pragma once

#include <pybind11/stl.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "app/python/arrays.hpp"
#include "app/python/shared_robot.hpp"
#include "calib/rig.hpp"
#include "localization/robot/estimate.hpp"
#include "localization/robot/image.hpp"
#include "localization/robot/sensors.hpp"

/// What the mapper and the localizer have in common for Python.
namespace ceilmap::python {

/// What both constructors take of the other sensors.
struct SensorArguments {
  std::optional<std::string> tilt;
  std::optional<std::filesystem::path> heading_model;

  /// @param rig  null: there is none. @throws InputError
  void Apply(const calib::Rig* rig, robot::SensorsParams& params) const;
};

/// The mapper and the localizer keep images for later ones: theirs is a copy, so that the caller
/// may use the array again. @throws InputError as ImageView.
robot::Image ToImage(
    const py::array& pixels, const char* name, bool colour, double stamp, std::int64_t index = 0);

/// Adds add_ceiling, add_ceiling_pipelined and flush, which both have.
/// @tparam Shared  holds the Robot.
template <typename Shared, typename Robot>
void BindCeiling(py::class_<Shared, SharedRobot>& cls) {
  const auto on_robot = [](auto work) {
    return [work](robot::Sensors& sensors) { return work(static_cast<Robot&>(sensors)); };
  };
  cls.def(
      "add_ceiling",
      [on_robot](
          Shared& self, const py::array& image, double stamp, std::optional<std::int64_t> index) {
        const robot::Image up = ToImage(image, "image", false, stamp, self.NextIndex(index));
        return self.Run(on_robot([&](Robot& robot) { return robot.AddCeiling(up); }));
      },
      py::arg("image"),
      py::arg("stamp"),
      py::arg("index") = py::none(),
      R"(Adds an upward image and returns the Estimate of the robot at this image.

image: uint8 (height, width), grey, of the size that the rig states. stamp: middle of the exposure,
seconds, later than the one before. index: number of the image, stored with its pose; None: one
more than before. The content of an image never raises an error.)");
  cls.def(
      "add_ceiling_pipelined",
      [on_robot](
          Shared& self, const py::array& image, double stamp, std::optional<std::int64_t> index) {
        const robot::Image up = ToImage(image, "image", false, stamp, self.NextIndex(index));
        return self.Run(on_robot([&](Robot& robot) { return robot.AddCeilingPipelined(up); }));
      },
      py::arg("image"),
      py::arg("stamp"),
      py::arg("index") = py::none(),
      R"(For recordings, at a higher rate: returns the Estimate at the image before.

Tilt and heading of this image are measured in the background while the image before is placed. The
first call returns None; flush() returns the last Estimate. `ceilmap map` and `ceilmap localize`
read recordings in this way.)");
  cls.def(
      "flush",
      [on_robot](Shared& self) {
        return self.Run(on_robot([](Robot& robot) { return robot.Flush(); }));
      },
      "The Estimate at the last image of add_ceiling_pipelined; None when there is none.");
}

}  // namespace ceilmap::python
