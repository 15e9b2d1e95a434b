#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <utility>

#include "app/python/bindings.hpp"
#include "app/python/robot_object.hpp"
#include "app/python/robot_types.hpp"
#include "localization/compass/colour/colour_model_file.hpp"

namespace ceilmap::python {
namespace {

using compensation::TiltMethod;

HeadingFrame ToFrame(const std::string& frame) {
  if (frame == "map") return HeadingFrame::kMap;
  if (frame == "relative") return HeadingFrame::kRelative;
  throw InputError(fmt::format("frame '{}': must be 'map' or 'relative'", frame));
}

constexpr const char* kSensorsDoc =
    R"(The sensors of a robot beside its upward camera; CeilingMapper and CeilingLocalizer have them.

All stamps are seconds of one clock, each stream has increasing stamps and may come at any rate.
What belongs to an upward image is added before that image: it is used with the image of each other
camera that is nearest in time. Headings come from one source: mirror images, a model of colours
(heading_model), or samples.

An object may be used from several threads: they wait for each other. Other threads of Python run
during each call. Images are copied, so that their arrays may be used again.)";

using Class = py::class_<SharedRobot>;

void BindCameras(Class& cls) {
  cls.def(
         "add_forward",
         [](SharedRobot& self, const py::array& image, double stamp) {
           const robot::Image taken = ToImage(image, "image", true, stamp);
           self.Run([&](robot::Sensors& sensors) { sensors.AddForward(taken); });
         },
         py::arg("image"),
         py::arg("stamp"),
         "Adds an image of the forward camera, uint8 (height, width) or BGR (height, width, 3),\n"
         "for the tilt; with heading_model it must be BGR.")
      .def(
          "add_omni",
          [](SharedRobot& self, const py::array& image, double stamp) {
            const robot::Image taken = ToImage(image, "image", true, stamp);
            self.Run([&](robot::Sensors& sensors) { sensors.AddOmni(taken); });
          },
          py::arg("image"),
          py::arg("stamp"),
          "Adds an image of the camera under the mirror, uint8 (height, width) or BGR\n"
          "(height, width, 3), for the heading. The rig needs the camera 'omni'.");
}

void BindHeadingAndWheels(Class& cls) {
  cls.def(
         "add_heading",
         [](SharedRobot& self,
            double heading,
            double sigma,
            double stamp,
            const std::string& frame) {
           const HeadingFrame counted = ToFrame(frame);
           self.Run([&](robot::Sensors& sensors) {
             sensors.AddHeading({stamp, heading, sigma}, counted);
           });
         },
         py::arg("heading"),
         py::arg("sigma"),
         py::arg("stamp"),
         py::arg("frame") = "relative",
         R"(Adds a heading of another program, with its standard deviation, radians.

Counter-clockwise seen from above, from an unknown direction that stays the same ('relative') or
from the x axis of the map ('map').)")
      .def(
          "add_odometry",
          [](SharedRobot& self, const PoseNumbers& pose, double stamp) {
            const Pose2 T_odom_base = ToPose(pose, "pose");
            self.Run([&](robot::Sensors& sensors) {
              sensors.AddOdometry(wheels::OdometrySample{stamp, T_odom_base});
            });
          },
          py::arg("pose"),
          py::arg("stamp"),
          "Adds a pose (x, y, yaw) of base by the wheels, in a frame of their own. It may come up\n"
          "to 0.15 s later than the image. Not together with add_speed.")
      .def(
          "add_speed",
          [](SharedRobot& self, double speed, double turn_rate, double stamp, double lateral) {
            self.Run([&](robot::Sensors& sensors) {
              sensors.AddOdometry(wheels::WheelSpeedSample{stamp, {{speed, lateral}, turn_rate}});
            });
          },
          py::arg("speed"),
          py::arg("turn_rate"),
          py::arg("stamp"),
          py::arg("lateral") = 0.0,
          "Adds the speed of the axle by the wheels, the mean since the sample before: forward,\n"
          "and lateral to the left, m/s; turn rate counter-clockwise, rad/s. Not together with\n"
          "add_odometry.")
      .def(
          "add_gyro",
          [](SharedRobot& self, double turn_rate, double stamp) {
            self.Run([&](robot::Sensors& sensors) { sensors.AddGyro({stamp, turn_rate}); });
          },
          py::arg("turn_rate"),
          py::arg("stamp"),
          "Adds the turn rate by a gyro, counter-clockwise seen from above, rad/s. It replaces\n"
          "the turn by the wheels. Without wheels its turns are headings.")
      .def(
          "sensed",
          [](SharedRobot& self) {
            return ToDict(self.Run([](robot::Sensors& sensors) { return sensors.Sensed(); }));
          },
          "What the sensors contributed so far: counts by sensor.");
}

}  // namespace

void SensorArguments::Apply(const calib::Rig* rig, robot::SensorsParams& params) const {
  static constexpr std::array<std::pair<const char*, TiltMethod>, 4> kMethods = {
      {{"matsumoto", TiltMethod::kMatsumoto},
       {"forward", TiltMethod::kForward},
       {"ceiling", TiltMethod::kCeiling},
       {"fused", TiltMethod::kFused}}};
  if (rig == nullptr) {
    if (tilt.value_or("none") != "none") {
      throw InputError(fmt::format(
          "tilt '{}': tilt can only be measured with the robot's geometry; give a Rig", *tilt));
    }
    if (heading_model) throw InputError("heading_model: needs the forward camera; give a Rig");
    params.measure_tilt = false;
    return;
  }
  const std::string method = tilt.value_or(rig->forward ? "fused" : "ceiling");
  params.measure_tilt = method != "none";
  bool known = !params.measure_tilt;
  for (const auto& [name, value] : kMethods) {
    if (method != name) continue;
    params.tilt.method = value;
    known = true;
  }
  if (!known) {
    throw InputError(fmt::format(
        "tilt '{}': must be 'none', 'matsumoto', 'forward', 'ceiling' or 'fused'", method));
  }
  if (heading_model) params.heading_model = colour::ReadColourModel(*heading_model);
}

robot::Image ToImage(
    const py::array& pixels, const char* name, bool colour, double stamp, std::int64_t index) {
  return {ImageView(pixels, name, colour).clone(), stamp, index};
}

void BindSensors(py::module_& module) {
  Class sensors(module, "Sensors", kSensorsDoc);
  BindCameras(sensors);
  BindHeadingAndWheels(sensors);
}

}  // namespace ceilmap::python
