#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "app/python/arrays.hpp"
#include "app/python/bindings.hpp"
#include "app/python/rig.hpp"
#include "app/python/robot_types.hpp"
#include "calib/base/error.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::python {
namespace {

using store::MapReader;
using store::MosaicGrid;

struct Mosaic {
  MosaicGrid grid;
  cv::Mat grey;
  cv::Mat alpha;
};

// Outer edges of the pixels: left, right, bottom, top.
std::tuple<double, double, double, double> ExtentOf(const MosaicGrid& grid) {
  return {grid.min_x,
          grid.min_x + grid.width_px * grid.resolution,
          grid.max_y - grid.height_px * grid.resolution,
          grid.max_y};
}

struct EdgeRow {
  std::int64_t from, to;
  Word kind;
  double x, y, yaw;
  std::array<double, 9> information;
};

const char* KindOf(const graph::Edge& edge) {
  switch (edge.kind) {
    case graph::Edge::Kind::kOdometry:
      return "odometry";
    case graph::Edge::Kind::kLoopClosure:
      return "loop";
    case graph::Edge::Kind::kWheels:
      return "wheels";
  }
  return "?";
}

py::array EdgeTable(const std::vector<graph::Edge>& edges) {
  std::vector<EdgeRow> rows;
  rows.reserve(edges.size());
  for (const graph::Edge& edge : edges) {
    const Pose2& T = edge.T_from_to;
    EdgeRow& row =
        rows.emplace_back(EdgeRow{edge.from, edge.to, ToWord(KindOf(edge)), T.x, T.y, T.yaw, {}});
    Eigen::Map<Eigen::Matrix3d>(row.information.data()) = edge.information;  // symmetric
  }
  return MakeTable(rows,
                   {{"from", "i8", offsetof(EdgeRow, from)},
                    {"to", "i8", offsetof(EdgeRow, to)},
                    {"kind", "U12", offsetof(EdgeRow, kind)},
                    {"x", "f8", offsetof(EdgeRow, x)},
                    {"y", "f8", offsetof(EdgeRow, y)},
                    {"yaw", "f8", offsetof(EdgeRow, yaw)},
                    {"information", "f8", offsetof(EdgeRow, information), 3}});
}

py::dict MetadataOf(const MapReader& map) {
  const store::MapMetadata& metadata = map.Metadata();
  py::dict dict;
  dict["format_version"] = metadata.format_version;
  dict["unit"] = metadata.unit;
  dict["resolution"] = metadata.resolution;
  dict["ceiling_height"] = metadata.ceiling_height_m;
  dict["rig_yaml"] = metadata.rig_yaml;
  dict["robot"] = metadata.robot;
  dict["view_size"] = std::pair(metadata.view_size.width, metadata.view_size.height);
  dict["view_units_per_px"] = metadata.view_units_per_px;
  dict["base_view"] = ToTuple(metadata.T_base_view);
  dict["program_version"] = metadata.program_version;
  dict["provenance"] = metadata.provenance;
  return dict;
}

// A map and the name under which it was opened.
class PyMap {
 public:
  explicit PyMap(std::filesystem::path path) : path_(std::move(path)), reader_(path_) {}

  [[nodiscard]] const MapReader& Reader() const { return reader_; }
  [[nodiscard]] const std::filesystem::path& Path() const { return path_; }

  // Reads while other threads of Python run.
  template <typename Read>
  auto Unlocked(const Read& read) const {
    const py::gil_scoped_release unlocked;
    return read(reader_);
  }

  [[nodiscard]] Mosaic ReadMosaic(std::optional<int> max_side) const {
    if (max_side && *max_side < 1) throw InputError("max_side: must be >= 1");
    const py::gil_scoped_release unlocked;
    Mosaic mosaic;
    if (max_side) {
      mosaic.grid = reader_.ReadOverview(*max_side, mosaic.grey, mosaic.alpha);
    } else {
      mosaic.grid = reader_.Grid();
      reader_.ReadMosaic(
          {0, 0, mosaic.grid.width_px, mosaic.grid.height_px}, mosaic.grey, mosaic.alpha);
    }
    return mosaic;
  }

 private:
  std::filesystem::path path_;
  MapReader reader_;
};

void BindMosaic(py::module_& module) {
  py::class_<Mosaic>(module, "Mosaic", R"(The mosaic of a map as seen from above: x right, y up.

    plt.imshow(mosaic.image, cmap="gray", extent=mosaic.extent)     # axes in map units

Pixel (row, column) has its centre at x = left + (column + 0.5) * resolution,
y = top - (row + 0.5) * resolution. The arrays share the memory of this object.)")
      .def_property_readonly(
          "image",
          [](const Mosaic& self) { return ToArray(self.grey); },
          "(height, width) uint8: grey levels.")
      .def_property_readonly(
          "alpha",
          [](const Mosaic& self) { return ToArray(self.alpha); },
          "(height, width) uint8: 0 where nothing was mapped.")
      .def_property_readonly(
          "extent",
          [](const Mosaic& self) { return ExtentOf(self.grid); },
          "(left, right, bottom, top): outer edges of the pixels, map units.")
      .def_property_readonly(
          "resolution",
          [](const Mosaic& self) { return self.grid.resolution; },
          "Map units per pixel.");
}

constexpr const char* kMapDoc = R"(A map, as `ceilmap map` or CeilingMapper wrote it, for reading.

Lengths are in metres; in a map without a rig, in pixels (metadata["unit"]). The tables are numpy's
structured arrays: map.keyframes["x"]. May be used from several threads.)";

void BindTables(py::class_<PyMap>& map) {
  map.def_property_readonly(
         "keyframes",
         [](const PyMap& self) {
           return ToTable(self.Unlocked([](const MapReader& m) { return m.ReadKeyframes(); }));
         },
         "Images that make the mosaic: id, stamp, frame, status, x, y, yaw, pitch, roll, lift,\n"
         "covariance (3, 3), ambiguous. Poses of base on the map; covariance of (x, y, yaw).")
      .def_property_readonly(
          "trajectory",
          [](const PyMap& self) {
            return ToTable(self.Unlocked([](const MapReader& m) { return m.ReadTrajectory(); }));
          },
          "Poses of all images on the map: stamp, frame, status, x, y, yaw, pitch, roll, lift,\n"
          "covariance (3, 3), keyframe.")
      .def_property_readonly(
          "poses",
          [](const PyMap& self) {
            return ToArray(ToStampedPoses(
                self.Unlocked([](const MapReader& m) { return m.ReadTrajectory(); })));
          },
          "(N, 8): the trajectory as stamp, x, y, z, qx, qy, qz, qw.")
      .def_property_readonly(
          "edges",
          [](const PyMap& self) {
            return EdgeTable(self.Unlocked([](const MapReader& m) { return m.ReadEdges(); }));
          },
          "Measured motions between keyframes: from, to, kind ('odometry', 'loop', 'wheels'), x,\n"
          "y, yaw (p_from = T p_to), information (3, 3).")
      .def_property_readonly(
          "weak_spots",
          [](const PyMap& self) {
            return ToTable(self.Unlocked([](const MapReader& m) { return m.ReadWeakSpots(); }));
          },
          "Where the map is less reliable: kind ('ambiguous', 'lost', 'unclosed'), keyframe,\n"
          "x, y, extent (map units; of 'lost' the number of images).");
}

}  // namespace

void BindMap(py::module_& module) {
  BindMosaic(module);
  py::class_<PyMap> map(module, "Map", kMapDoc);
  map.def(py::init([](const std::filesystem::path& path) {
            const py::gil_scoped_release unlocked;
            return std::make_unique<PyMap>(path);
          }),
          py::arg("path"),
          "Raises InputError when the file is missing or no map.")
      .def(
          "mosaic",
          &PyMap::ReadMosaic,
          py::arg("max_side") = py::none(),
          "Reads the Mosaic. max_side: reduced, by a power of two, until no side has more pixels;\n"
          "small and fast for maps of any size. None: at full resolution.")
      .def(
          "image",
          [](const PyMap& self, std::int64_t keyframe) {
            return ToArray(
                self.Unlocked([&](const MapReader& m) { return m.ReadImage(keyframe); }));
          },
          py::arg("keyframe"),
          "The image of a keyframe, by its id: (height, width) uint8, rectified, seen from below.")
      .def(
          "rig",
          [](const PyMap& self) { return RigOf(self.Reader(), self.Path().string()); },
          "The Rig of the robot that made the map. Raises InputError when it has none.")
      .def_property_readonly("path", &PyMap::Path, "The file.")
      .def_property_readonly(
          "metadata",
          [](const PyMap& self) { return MetadataOf(self.Reader()); },
          "unit ('m' or 'px'), resolution, ceiling_height, robot, rig_yaml, provenance, ...")
      .def_property_readonly(
          "quality",
          [](const PyMap& self) { return ToDict(self.Reader().Quality()); },
          "Agreement of the measurements: chi2_per_dof, loops, ...")
      .def_property_readonly(
          "extent",
          [](const PyMap& self) { return ExtentOf(self.Reader().Grid()); },
          "(left, right, bottom, top) of the mosaic, map units.");
  BindTables(map);
}

}  // namespace ceilmap::python
