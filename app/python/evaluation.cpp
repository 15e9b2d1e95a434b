#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/evaluation/trajectory_errors.hpp"
#include "app/python/arrays.hpp"
#include "app/python/bindings.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"

namespace ceilmap::python {
namespace {

using evaluation::Alignment;
using evaluation::ErrorStatistics;
using evaluation::PoseErrorStatistics;
using evaluation::TrajectoryErrors;

struct ErrorRow {
  double stamp, distance;
  double x, y, yaw;
  double position, along, across;
  double yaw_deg, pitch_deg, roll_deg;
  std::int64_t truth, estimate;
};

py::array ErrorTable(const std::vector<evaluation::FrameError>& frames) {
  std::vector<ErrorRow> rows;
  rows.reserve(frames.size());
  for (const evaluation::FrameError& frame : frames) {
    rows.push_back({frame.stamp_s,
                    frame.distance_m,
                    frame.T_truth_base.x,
                    frame.T_truth_base.y,
                    frame.T_truth_base.yaw,
                    frame.position_m,
                    frame.along_m,
                    frame.across_m,
                    frame.yaw_deg,
                    frame.pitch_deg,
                    frame.roll_deg,
                    static_cast<std::int64_t>(frame.truth),
                    static_cast<std::int64_t>(frame.estimate)});
  }
  return MakeTable(rows,
                   {{"stamp", "f8", offsetof(ErrorRow, stamp)},
                    {"distance_m", "f8", offsetof(ErrorRow, distance)},
                    {"x", "f8", offsetof(ErrorRow, x)},
                    {"y", "f8", offsetof(ErrorRow, y)},
                    {"yaw", "f8", offsetof(ErrorRow, yaw)},
                    {"position_m", "f8", offsetof(ErrorRow, position)},
                    {"along_m", "f8", offsetof(ErrorRow, along)},
                    {"across_m", "f8", offsetof(ErrorRow, across)},
                    {"yaw_deg", "f8", offsetof(ErrorRow, yaw_deg)},
                    {"pitch_deg", "f8", offsetof(ErrorRow, pitch_deg)},
                    {"roll_deg", "f8", offsetof(ErrorRow, roll_deg)},
                    {"truth", "i8", offsetof(ErrorRow, truth)},
                    {"estimate", "i8", offsetof(ErrorRow, estimate)}});
}

py::dict ErrorsDict(const ErrorStatistics& statistics) {
  py::dict dict;
  dict["rmse"] = statistics.rmse;
  dict["mean"] = statistics.mean;
  dict["median"] = statistics.median;
  dict["p95"] = statistics.p95;
  dict["max"] = statistics.max;
  dict["std"] = statistics.std;
  dict["min"] = statistics.min;
  dict["p75"] = statistics.p75;
  dict["p90"] = statistics.p90;
  dict["p99"] = statistics.p99;
  dict["count"] = statistics.count;
  return dict;
}

py::dict ErrorsDict(const PoseErrorStatistics& statistics) {
  py::dict dict;
  dict["translation_m"] = ErrorsDict(statistics.translation_m);
  dict["rotation_deg"] = ErrorsDict(statistics.rotation_deg);
  dict["rotation_block"] = ErrorsDict(statistics.rotation_block);
  dict["full"] = ErrorsDict(statistics.full);
  return dict;
}

template <typename Statistics>
void Put(py::dict& dict, const char* key, const std::optional<Statistics>& statistics) {
  if (statistics) dict[key] = ErrorsDict(*statistics);
}

// The keys are those of metrics.json (app/reports/evaluation_json.cpp).
py::dict ErrorsDict(const TrajectoryErrors& errors) {
  py::dict dict;
  dict["matched"] = errors.matched;
  dict["expected"] = errors.expected;
  dict["coverage"] = errors.Coverage();
  dict["path_m"] = errors.path_m;
  dict["position_m"] = ErrorsDict(errors.position_m);
  dict["yaw_deg"] = ErrorsDict(errors.yaw_deg);
  Put(dict, "per_metre_m", errors.per_metre_m);
  Put(dict, "per_metre_yaw_deg", errors.per_metre_yaw_deg);
  py::dict alignment;
  alignment["x"] = errors.T_truth_estimate.motion.x;
  alignment["y"] = errors.T_truth_estimate.motion.y;
  alignment["yaw_deg"] = kDegPerRad * errors.T_truth_estimate.motion.yaw;
  alignment["scale"] = errors.T_truth_estimate.scale;
  dict["alignment"] = alignment;
  dict["tilted"] = errors.tilted;
  dict["ape"] = ErrorsDict(errors.pose);
  py::dict rpe;
  Put(rpe, "frame", errors.per_frame);
  Put(rpe, "metre", errors.per_metre);
  Put(rpe, "metre_all_pairs", errors.per_metre_all_pairs);
  dict["rpe"] = rpe;
  py::list segments;
  for (const evaluation::SegmentErrors& errors_of_length : errors.segments) {
    py::dict segment;
    segment["length_m"] = errors_of_length.length_m;
    segment["translation_percent"] = ErrorsDict(errors_of_length.translation_percent);
    segment["rotation_deg_per_m"] = ErrorsDict(errors_of_length.rotation_deg_per_m);
    segments.append(segment);
  }
  dict["segments"] = segments;
  dict["frames"] = ErrorTable(errors.frames);
  return dict;
}

Alignment ToAlignment(const std::string& align) {
  if (align == "none") return Alignment::kNone;
  if (align == "first") return Alignment::kFirst;
  if (align == "se2") return Alignment::kSe2;
  if (align == "sim2") return Alignment::kSim2;
  throw InputError(fmt::format("align '{}': must be 'none', 'first', 'se2' or 'sim2'", align));
}

py::dict Evaluate(const py::array& truth_array,
                  const py::array& estimate_array,
                  const std::string& align,
                  double max_dt,
                  std::optional<std::int64_t> expected) {
  const std::vector<StampedPose> truth = ToPoses(truth_array, "truth");
  const std::vector<StampedPose> estimate = ToPoses(estimate_array, "estimate");
  if (!(max_dt >= 0)) throw InputError(fmt::format("max_dt {}: must be >= 0 s", max_dt));
  evaluation::EvaluationParams params;
  params.align = ToAlignment(align);
  params.max_dt_s = max_dt;
  params.expected = expected;
  std::optional<TrajectoryErrors> errors;
  {
    const py::gil_scoped_release unlocked;
    errors = evaluation::EvaluateTrajectory(truth, estimate, params);
  }
  if (!errors) {
    throw InputError(
        fmt::format("no pose of the estimate is within {} s of a true one; are the stamps of one "
                    "clock?",
                    max_dt));
  }
  if (errors->matched > errors->expected) {
    throw InputError(fmt::format("expected {}: {} poses of the estimate have a true one",
                                 errors->expected,
                                 errors->matched));
  }
  return ErrorsDict(*errors);
}

constexpr const char* kEvaluateDoc =
    R"(Errors of an estimated trajectory relative to the true one, as `ceilmap evaluate` has them.

truth, estimate: arrays of (N, 8) stamp, x, y, z, qx, qy, qz, qw (numpy.loadtxt reads such a TUM
    file; Map.poses is one), or of (N, 4) stamp, x, y, yaw of a level robot; stamps strictly
    increasing, seconds; metres, radians.
align: how the estimate is moved to the truth before: 'none', 'first' (the first poses coincide),
    'se2' (the planar motion of least squares), 'sim2' (the same with a scale).
max_dt: poses further apart in time are not compared, seconds.
expected: number of expected poses, for the coverage; None: as many as the truth has.

Returns a dict with the keys of the program's metrics.json: matched, coverage, position_m, yaw_deg,
ape and rpe as evo defines them (translation_m, rotation_deg, ...), segments as KITTI's; each with
rmse, mean, median, max, ... 'frames' is a structured array with the errors of each pose.)";

}  // namespace

void BindEvaluation(py::module_& module) {
  module.def("evaluate",
             &Evaluate,
             py::arg("truth"),
             py::arg("estimate"),
             py::kw_only(),
             py::arg("align") = "se2",
             py::arg("max_dt") = evaluation::EvaluationParams{}.max_dt_s,
             py::arg("expected") = py::none(),
             kEvaluateDoc);
}

}  // namespace ceilmap::python
