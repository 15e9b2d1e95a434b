#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "app/python/bindings.hpp"
#include "app/python/robot_object.hpp"
#include "app/python/settings.hpp"
#include "localization/robot/ceiling_mapper.hpp"

namespace ceilmap::python {
namespace {

namespace fs = std::filesystem;

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
  if (append) params.append = mapping::HeldPoses::kFirstKeyframe;
  params.resolution = resolution;
  params.provenance = provenance;
  SensorArguments{tilt, heading_model}.Apply(rig ? &*rig : nullptr, params.sensors);
  return std::make_unique<PyMapper>(rig, map, size, params);
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

}  // namespace

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

}  // namespace ceilmap::python
