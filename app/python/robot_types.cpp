#include "app/python/robot_types.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/python/arrays.hpp"
#include "app/python/bindings.hpp"
#include "localization/robot/estimate.hpp"

namespace ceilmap::python {
namespace {

using mapping::MappingResult;
using robot::Estimate;
using robot::TrackingStatus;

// By the image or by the wheels.
bool IsKnown(const Estimate& estimate) {
  return estimate.HasPose() || estimate.status == TrackingStatus::kPredicted;
}

std::optional<std::tuple<double, double, double>> PoseOf(const Estimate& estimate) {
  if (!IsKnown(estimate)) return std::nullopt;
  return ToTuple(estimate.pose.pose);
}

std::optional<py::array> CovarianceOf(const Estimate& estimate) {
  if (!IsKnown(estimate)) return std::nullopt;
  return ToArray(estimate.pose.covariance);
}

std::optional<py::array> MatrixOf(const Estimate& estimate) {
  if (!IsKnown(estimate)) return std::nullopt;
  return ToArray(ToSpace(estimate.pose.pose, estimate.tilt).matrix());
}

std::optional<py::array> TumOf(const Estimate& estimate) {
  if (!IsKnown(estimate)) return std::nullopt;
  return ToArray({ToStampedPose(estimate.stamp_s, estimate.pose.pose, estimate.tilt)})
      .attr("reshape")(-1)
      .cast<py::array>();
}

py::array PlacesOf(const Estimate& estimate) {
  Eigen::MatrixXd places(estimate.places.size(), 4);
  for (std::size_t i = 0; i < estimate.places.size(); ++i) {
    const auto& [pose, weight] = estimate.places[i];
    places.row(static_cast<Eigen::Index>(i)) << pose.x, pose.y, pose.yaw, weight;
  }
  return ToArray(places);
}

std::string Represent(const Estimate& estimate) {
  std::string text = fmt::format(
      "<ceilmap.Estimate {:.3f} s, {}", estimate.stamp_s, graph::ToString(estimate.status));
  if (IsKnown(estimate)) {
    const Pose2& pose = estimate.pose.pose;
    text += fmt::format(" ({:.4f}, {:.4f}, {:.4f})", pose.x, pose.y, pose.yaw);
  }
  return text + ">";
}

struct WeakSpotRow {
  Word kind;
  std::int64_t keyframe;
  double x, y, extent;
};

py::dict StreamDict(const robot::StreamReport& report) {
  py::dict dict;
  dict["matched"] = report.matched;
  dict["missing"] = report.missing;
  dict["largest_offset"] = report.largest_offset_s;
  return dict;
}

constexpr const char* kEstimateDoc = R"(What is known of the robot at an upward image.

Nothing is guessed: pose, covariance, matrix and tum are None while the pose is not known (status
'lost' or 'ambiguous'). An Estimate is true where the image determined the pose (status 'tracking'
or 'relocalized').)";

void BindPose(py::class_<Estimate>& cls) {
  cls.def_readonly("stamp", &Estimate::stamp_s, "Time of the image, seconds.")
      .def_readonly("index", &Estimate::index, "Number of the image.")
      .def_property_readonly(
          "status",
          [](const Estimate& self) { return graph::ToString(self.status); },
          "'tracking', 'relocalized' (known again, or for the first time), 'predicted' (by wheels\n"
          "alone), 'ambiguous' (several places fit) or 'lost'.")
      .def_property_readonly(
          "pose",
          &PoseOf,
          "(x, y, yaw) of base on the map: metres (pixels without a rig), radians in (-pi, pi],\n"
          "counter-clockwise seen from above.")
      .def_property_readonly(
          "covariance",
          &CovarianceOf,
          "(3, 3): of (x, y, yaw), m^2, m rad, rad^2. The mapper's is that of its odometry;\n"
          "Map.trajectory has the final ones.")
      .def_property_readonly(
          "matrix", &MatrixOf, "(4, 4): p_map = matrix @ p_base, with the tilt of the robot.")
      .def_property_readonly(
          "tum", &TumOf, "(8,): stamp, x, y, z, qx, qy, qz, qw, a line of a trajectory file.");
}

void BindMeasured(py::class_<Estimate>& cls) {
  cls.def_property_readonly(
         "tilt",
         [](const Estimate& self) { return std::pair(self.tilt.pitch_rad, self.tilt.roll_rad); },
         "(pitch, roll) that was taken out of the image, radians: pitch > 0 has the nose down,\n"
         "roll > 0 the left side up; (0, 0) where the robot is level.")
      .def_property_readonly(
          "lift",
          [](const Estimate& self) { return self.tilt.lift_m; },
          "Of the mast's foot above the floor, metres.")
      .def_property_readonly(
          "heading",
          [](const Estimate& self) -> std::optional<std::pair<double, double>> {
            if (!self.heading) return std::nullopt;
            return std::pair(self.heading->heading_rad, std::sqrt(self.heading->variance_rad2));
          },
          "(heading, sigma) as measured, radians; None without. Counted from the direction of its\n"
          "own source (heading_frame).")
      .def_property_readonly(
          "heading_frame",
          [](const Estimate& self) -> std::optional<const char*> {
            if (!self.heading) return std::nullopt;
            return self.heading->frame == HeadingFrame::kMap ? "map" : "relative";
          },
          "'map': headings count from the map's x axis; 'relative': from an unknown direction.")
      .def_readonly("peak", &Estimate::peak, "Localizer: agreement with the map, 0 to 1.")
      .def_readonly("inliers", &Estimate::inliers, "Localizer: blocks that agree with the map ...")
      .def_readonly("blocks", &Estimate::blocks, "... of so many that were compared.")
      .def_readonly("hypotheses",
                    &Estimate::hypotheses,
                    "Places where the robot may be, while it is unknown.")
      .def_property_readonly(
          "places", &PlacesOf, "(N, 4): these places, x, y, yaw, weight; the weights sum to 1.")
      .def_readonly("keyframe",
                    &Estimate::keyframe_id,
                    "Mapper: keyframe against which the image was measured; -1: none.");
}

void BindEstimate(py::module_& module) {
  py::class_<Estimate> cls(module, "Estimate", kEstimateDoc);
  BindPose(cls);
  BindMeasured(cls);
  cls.def("__bool__", &Estimate::HasPose).def("__repr__", &Represent);
}

void BindMappingResult(py::module_& module) {
  py::class_<MappingResult>(module, "MappingResult", R"(What CeilingMapper.finish() made.

Map(path) reads the map itself.)")
      .def_property_readonly(
          "trajectory",
          [](const MappingResult& self) { return ToTable(self.frames); },
          "The frames of the recording that are on the map, optimized: a structured array as\n"
          "Map.trajectory.")
      .def_property_readonly(
          "predicted",
          [](const MappingResult& self) { return ToTable(self.predicted); },
          "Frames whose pose only the wheels know, as trajectory.")
      .def_property_readonly(
          "poses",
          [](const MappingResult& self) { return ToArray(ToStampedPoses(self.frames)); },
          "(N, 8): the trajectory as stamp, x, y, z, qx, qy, qz, qw.")
      .def_property_readonly(
          "report",
          [](const MappingResult& self) { return ToDict(self.report); },
          "Counts of frames, and figures of quality.")
      .def_property_readonly(
          "weak_spots",
          [](const MappingResult& self) { return ToTable(self.weak_spots); },
          "Where the map is less reliable: a structured array as Map.weak_spots.");
}

}  // namespace

py::dict ToDict(const graph::MapQuality& quality) {
  const graph::LoopCounts& counts = quality.loops;
  py::dict loops;
  loops["compared"] = counts.compared;
  loops["accepted"] = counts.accepted;
  loops["no_match"] = counts.no_match;
  loops["ambiguous"] = counts.ambiguous;
  loops["off_prediction"] = counts.off_prediction;
  loops["unconfirmed"] = counts.unconfirmed;
  loops["outliers"] = counts.outliers;
  py::dict dict;
  dict["loops"] = loops;
  dict["chi2_per_dof"] = quality.chi2_per_dof;
  dict["max_edge_sigmas"] = quality.max_edge_sigmas;
  dict["odometry_rms"] = quality.odometry_rms;
  dict["loop_rms"] = quality.loop_rms;
  return dict;
}

py::dict ToDict(const mapping::MapperReport& report) {
  py::dict dict;
  dict["frames"] = report.frames;
  dict["tracked"] = report.tracked;
  dict["lost"] = report.lost;
  dict["ambiguous"] = report.ambiguous;
  dict["predicted"] = report.predicted;
  dict["without_texture"] = report.without_texture;
  dict["unconnected"] = report.unconnected;
  dict["missing"] = report.missing;
  dict["repeated"] = report.repeated;
  dict["keyframes"] = report.keyframes;
  dict["path"] = report.path;
  dict["median_peak"] = report.median_peak;
  dict["quality"] = ToDict(report.quality);
  return dict;
}

py::dict ToDict(const localization::LocalizerReport& report) {
  py::dict dict;
  dict["frames"] = report.frames;
  dict["tracking"] = report.tracking;
  dict["relocalized"] = report.relocalized;
  dict["predicted"] = report.predicted;
  dict["ambiguous"] = report.ambiguous;
  dict["lost"] = report.lost;
  dict["slips"] = report.slips;
  dict["repeated"] = report.repeated;
  dict["searches"] = report.searches;
  dict["scale"] = report.scale;
  return dict;
}

py::dict ToDict(const robot::SensorsReport& report) {
  py::dict dict;
  dict["forward"] = StreamDict(report.forward);
  dict["omni"] = StreamDict(report.omni);
  if (report.heading) {
    py::dict heading;
    heading["headings"] = report.heading->headings;
    heading["uncertain"] = report.heading->uncertain;
    heading["missing"] = report.heading->missing;
    dict["heading"] = heading;
  }
  if (report.wheels.samples > 0) {
    py::dict wheels;
    wheels["samples"] = report.wheels.samples;
    wheels["gyro"] = report.wheels.gyro;
    wheels["missing"] = report.wheels.missing;
    wheels["pieces"] = report.wheels.pieces;
    wheels["slips"] = report.wheels.slips;
    wheels["gyro_stuck_s"] = report.wheels.gyro_stuck_s;
    wheels["used"] = report.wheels.fault == wheels::WheelFault::kNone;
    wheels["scale"] = report.wheels.model.scale.value;
    wheels["turn_scale"] = report.wheels.model.turn_scale.value;
    dict["wheels"] = wheels;
  }
  return dict;
}

py::array ToTable(const std::vector<graph::WeakSpot>& spots) {
  std::vector<WeakSpotRow> rows;
  rows.reserve(spots.size());
  for (const graph::WeakSpot& spot : spots) {
    rows.push_back(
        {ToWord(graph::ToString(spot.kind)), spot.keyframe_id, spot.x, spot.y, spot.extent});
  }
  return MakeTable(rows,
                   {{"kind", "U12", offsetof(WeakSpotRow, kind)},
                    {"keyframe", "i8", offsetof(WeakSpotRow, keyframe)},
                    {"x", "f8", offsetof(WeakSpotRow, x)},
                    {"y", "f8", offsetof(WeakSpotRow, y)},
                    {"extent", "f8", offsetof(WeakSpotRow, extent)}});
}

void BindRobotTypes(py::module_& module) {
  BindEstimate(module);
  BindMappingResult(module);
}

}  // namespace ceilmap::python
