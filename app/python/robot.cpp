#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "app/python/arrays.hpp"
#include "app/python/bindings.hpp"
#include "app/python/rig.hpp"
#include "app/python/robot_types.hpp"
#include "app/python/settings.hpp"
#include "app/python/shared_robot.hpp"
#include "calib/base/degrees.hpp"
#include "localization/compass/colour/colour_model_file.hpp"
#include "localization/robot/ceiling_localizer.hpp"
#include "localization/robot/ceiling_mapper.hpp"

namespace ceilmap::python {
namespace {

namespace fs = std::filesystem;

using compensation::TiltMethod;
using robot::Estimate;
using OptionalIndex = std::optional<std::int64_t>;

// What both constructors take of the other sensors.
struct SensorArguments {
  std::optional<std::string> tilt;
  std::optional<fs::path> heading_model;

  // @throws InputError @param rig  null: there is none.
  void Apply(const calib::Rig* rig, robot::SensorsParams& params) const;
};

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

// The mapper and the localizer keep images for later ones: theirs is a copy, so that the caller may
// use the array again.
robot::Image ToImage(
    const py::array& pixels, const char* name, bool colour, double stamp, std::int64_t index = 0) {
  return {ImageView(pixels, name, colour).clone(), stamp, index};
}

HeadingFrame ToFrame(const std::string& frame) {
  if (frame == "map") return HeadingFrame::kMap;
  if (frame == "relative") return HeadingFrame::kRelative;
  throw InputError(fmt::format("frame '{}': must be 'map' or 'relative'", frame));
}

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

// Calls Python's function, and lets Ctrl-C end the work. What either raises ends it.
robot::ProgressFunction ProgressOf(const py::object& function) {
  return [&function](int done, int total) {
    const py::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!function.is_none()) function(done, total);
  };
}

class PyMapper : public SharedRobot {
 public:
  PyMapper(const std::optional<calib::Rig>& rig,
           const fs::path& map,
           const std::optional<std::pair<int, int>>& size,
           const robot::CeilingMapperParams& params)
      : mapper_(Make(rig, map, size, params)) {}

  template <typename Work>
  auto RunMapper(const Work& work) {
    return Run([&](robot::Sensors&) { return work(*mapper_); });
  }

  // The mapper ends with the call, so that the file's name is free again, whatever is thrown.
  mapping::MappingResult Finish(const py::object& progress) {
    const robot::ProgressFunction show = ProgressOf(progress);
    return RunMapper([&](robot::CeilingMapper&) {
      End("the map is finished; make a new CeilingMapper");
      const std::unique_ptr<robot::CeilingMapper> mapper = std::move(mapper_);
      return mapper->Finish(show);
    });
  }

  // Removes the hidden file.
  void Discard() {
    RunMapper([&](robot::CeilingMapper&) {
      End("the map was discarded; make a new CeilingMapper");
      mapper_.reset();
    });
  }

 private:
  static std::unique_ptr<robot::CeilingMapper> Make(const std::optional<calib::Rig>& rig,
                                                    const fs::path& map,
                                                    const std::optional<std::pair<int, int>>& size,
                                                    const robot::CeilingMapperParams& params) {
    if (rig) return std::make_unique<robot::CeilingMapper>(*rig, map, params);
    if (!size) throw InputError("rig is None: give size=(width, height) of the images");
    return std::make_unique<robot::CeilingMapper>(cv::Size(size->first, size->second), map, params);
  }
  robot::Sensors& Sensors() override { return *mapper_; }

  std::unique_ptr<robot::CeilingMapper> mapper_;
};

class PyLocalizer : public SharedRobot {
 public:
  PyLocalizer(const fs::path& map,
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

std::unique_ptr<PyMapper> MakeMapper(const std::optional<calib::Rig>& rig,
                                     const fs::path& map,
                                     const std::optional<std::pair<int, int>>& size,
                                     const std::optional<PoseNumbers>& origin,
                                     const std::optional<double>& resolution,
                                     bool append,
                                     const std::optional<std::string>& tilt,
                                     const std::optional<fs::path>& heading_model,
                                     const py::object& settings,
                                     const std::string& provenance) {
  const ModuleSettings read = ReadSettings(settings);
  const py::gil_scoped_release unlocked;
  if (resolution && !(*resolution > 0 && *resolution < 1e6)) {
    throw InputError(
        fmt::format("resolution {}: must be > 0, map units per pixel of the map", *resolution));
  }
  robot::CeilingMapperParams params;
  params.sensors = read.sensors;
  params.mapping = read.mapping;
  if (origin) params.mapping.origin = ToPose(*origin, "origin");
  params.append = append;
  params.resolution = resolution;
  params.provenance = provenance;
  SensorArguments{tilt, heading_model}.Apply(rig ? &*rig : nullptr, params.sensors);
  return std::make_unique<PyMapper>(rig, map, size, params);
}

std::unique_ptr<PyLocalizer> MakeLocalizer(const fs::path& map,
                                           const std::optional<calib::Rig>& rig,
                                           const std::optional<PoseNumbers>& start,
                                           const std::optional<py::array>& start_covariance,
                                           const std::optional<std::string>& tilt,
                                           const std::optional<fs::path>& heading_model,
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

constexpr const char* kSensorsDoc =
    R"(The sensors of a robot beside its upward camera; CeilingMapper and CeilingLocalizer have them.

All stamps are seconds of one clock, each stream has increasing stamps and may come at any rate.
What belongs to an upward image is added before that image: it is used with the image of each other
camera that is nearest in time. Headings come from one source: mirror images, a model of colours
(heading_model), or samples.

An object may be used from several threads: they wait for each other. Other threads of Python run
during each call. Images are copied, so that their arrays may be used again.)";

void BindSensors(py::module_& module) {
  py::class_<SharedRobot>(module, "Sensors", kSensorsDoc)
      .def(
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
          "(height, width, 3), for the heading. The rig needs the camera 'omni'.")
      .def(
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
          "Adds a pose (x, y, yaw) of base by the wheels, in a frame of their own; metres, "
          "radians.\n"
          "It may come up to 0.15 s later than the image. Not together with add_speed.")
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
          "Adds the speed of the axle by the wheels, the mean since the sample before: forward "
          "and\n"
          "to the left, m/s, turn rate counter-clockwise, rad/s. Not together with add_odometry.")
      .def(
          "add_gyro",
          [](SharedRobot& self, double turn_rate, double stamp) {
            self.Run([&](robot::Sensors& sensors) { sensors.AddGyro({stamp, turn_rate}); });
          },
          py::arg("turn_rate"),
          py::arg("stamp"),
          "Adds the turn rate by a gyro, counter-clockwise seen from above, rad/s. It replaces "
          "the\n"
          "turn by the wheels, which are needed too.")
      .def(
          "sensed",
          [](SharedRobot& self) {
            return ToDict(self.Run([](robot::Sensors& sensors) { return sensors.Sensed(); }));
          },
          "What the sensors contributed so far: counts by sensor.");
}

// AddCeiling, AddCeilingPipelined and Flush, which both have.
template <typename Shared, typename Robot>
void BindCeiling(py::class_<Shared, SharedRobot>& cls) {
  const auto on_robot = [](auto work) {
    return [work](robot::Sensors& sensors) { return work(static_cast<Robot&>(sensors)); };
  };
  cls.def(
      "add_ceiling",
      [on_robot](Shared& self, const py::array& image, double stamp, OptionalIndex index) {
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
      [on_robot](Shared& self, const py::array& image, double stamp, OptionalIndex index) {
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

constexpr const char* kMapperDoc =
    R"(Builds a map of the ceiling while a robot drives.

    mapper = ceilmap.CeilingMapper(ceilmap.Rig.load("rig.yaml"), "lab.gpkg")
    for stamp, image in camera:
        estimate = mapper.add_ceiling(image, stamp)     # by the odometry
    mapper.finish()                                     # optimizes all poses, writes lab.gpkg

The file appears complete with finish(), and replaces one of its name; until then, and without, the
one that was there stays.)";

constexpr const char* kMapperInitDoc =
    R"(rig: a Rig with an upward camera; None: lengths are in pixels, and size is needed.
map: the file, ends in .gpkg.
size: (width, height) of the images, without a rig.
origin: (x, y, yaw) of the first image on the map; None: (0, 0, 0).
resolution: map units per pixel of the mosaic; None: that of the camera.
append: extend the map; the recording may begin anywhere on it. It is not changed if nothing
    matches.
tilt: 'none', 'matsumoto', 'forward', 'ceiling' or 'fused'; None: 'fused' with a forward camera in
    the rig, 'ceiling' with another rig.
heading_model: file of `ceilmap compass learn`: headings by the colours in add_forward's images.
settings: see default_settings.
provenance: one line that is stored in the map.)";

void BindMapper(py::module_& module) {
  py::class_<PyMapper, SharedRobot> mapper(module, "CeilingMapper", kMapperDoc);
  mapper.def(py::init(&MakeMapper),
             py::arg("rig"),
             py::arg("map"),
             py::kw_only(),
             py::arg("size") = py::none(),
             py::arg("origin") = py::none(),
             py::arg("resolution") = py::none(),
             py::arg("append") = false,
             py::arg("tilt") = py::none(),
             py::arg("heading_model") = py::none(),
             py::arg("settings") = py::none(),
             py::arg("provenance") = "",
             kMapperInitDoc);
  BindCeiling<PyMapper, robot::CeilingMapper>(mapper);
  mapper
      .def("finish",
           &PyMapper::Finish,
           py::arg("progress") = py::none(),
           R"(Optimizes all poses, draws the mosaic and writes the map. Returns a MappingResult.

progress: called as progress(done, total) while the mosaic is drawn, without locks of Python held
by the mapper. What it raises, and Ctrl-C, ends the work: the map is then not written. Raises
RunError when no image showed any texture, or the recording does not join the map to extend.)")
      .def("discard",
           &PyMapper::Discard,
           "Ends without a map: the file that was there stays, and its name is free again.")
      .def_property_readonly(
          "placed_frames",
          [](PyMapper& self) {
            return self.RunMapper([](robot::CeilingMapper& m) { return m.PlacedFrames(); });
          },
          "Images placed on the map so far.");
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

}  // namespace

void BindRobot(py::module_& module) {
  BindSensors(module);
  BindMapper(module);
  BindLocalizer(module);
}

}  // namespace ceilmap::python
