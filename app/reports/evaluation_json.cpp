#include "app/reports/evaluation_json.hpp"

#include <optional>

#include "calib/base/degrees.hpp"

namespace ceilmap::reports {

using evaluation::Compensation;
using evaluation::CompensationRatio;
using evaluation::Consistency;
using evaluation::ErrorStatistics;
using evaluation::HeadingErrors;
using evaluation::Nees;
using evaluation::PathErrors;
using evaluation::PoseErrorStatistics;
using evaluation::SegmentErrors;
using evaluation::TimeOffset;
using evaluation::TrajectoryErrors;
using nlohmann::ordered_json;

namespace {

ordered_json NeesToJson(const Nees& nees) {
  return {{"mean", nees.mean},
          {"expected", nees.expected},
          {"median", nees.median},
          {"inside_95", nees.inside_95}};
}

}  // namespace

ordered_json ToJson(const ErrorStatistics& statistics) {
  return {{"rmse", statistics.rmse},
          {"mean", statistics.mean},
          {"median", statistics.median},
          {"p95", statistics.p95},
          {"max", statistics.max},
          {"std", statistics.std},
          {"min", statistics.min},
          {"p75", statistics.p75},
          {"p90", statistics.p90},
          {"p99", statistics.p99},
          {"count", statistics.count}};
}

ordered_json ToJson(const PoseErrorStatistics& statistics) {
  return {{"translation_m", ToJson(statistics.translation_m)},
          {"rotation_deg", ToJson(statistics.rotation_deg)},
          {"rotation_block", ToJson(statistics.rotation_block)},
          {"full", ToJson(statistics.full)}};
}

ordered_json ToJson(const Similarity2& T) {
  return {{"x", T.motion.x},
          {"y", T.motion.y},
          {"yaw_deg", kDegPerRad * T.motion.yaw},
          {"scale", T.scale}};
}

ordered_json ToJson(const SegmentErrors& errors) {
  return {{"length_m", errors.length_m},
          {"translation_percent", ToJson(errors.translation_percent)},
          {"rotation_deg_per_m", ToJson(errors.rotation_deg_per_m)}};
}

ordered_json ToJson(const TrajectoryErrors& errors) {
  ordered_json json = {{"position_m", ToJson(errors.position_m)},
                       {"yaw_deg", ToJson(errors.yaw_deg)}};
  if (errors.per_metre_m) json["per_metre_m"] = ToJson(*errors.per_metre_m);
  if (errors.per_metre_yaw_deg) json["per_metre_yaw_deg"] = ToJson(*errors.per_metre_yaw_deg);
  json["alignment"] = ToJson(errors.T_truth_estimate);
  json["tilted"] = errors.tilted;
  json["ape"] = ToJson(errors.pose);
  json["rpe"] = ordered_json::object();
  const auto add = [&](const char* key, const std::optional<PoseErrorStatistics>& statistics) {
    if (statistics) json["rpe"][key] = ToJson(*statistics);
  };
  add("frame", errors.per_frame);
  add("metre", errors.per_metre);
  add("metre_all_pairs", errors.per_metre_all_pairs);
  json["segments"] = ordered_json::array();
  for (const SegmentErrors& segment : errors.segments) json["segments"].push_back(ToJson(segment));
  return json;
}

ordered_json ToJson(const HeadingErrors& errors) {
  const auto or_null = [](const std::optional<double>& value) {
    return value ? ordered_json(*value) : ordered_json(nullptr);
  };
  return {{"matched", errors.of.size()},
          {"coverage", errors.coverage},
          {"turned_deg", errors.turned_deg},
          {"path_m", errors.path_m},
          {"error_deg", ToJson(errors.error_deg)},
          {"signed_mean_deg", errors.signed_mean_deg},
          {"std_deg", errors.std_deg},
          {"end_deg", errors.end_deg},
          {"drift_deg_per_m", or_null(errors.drift_deg_per_m)},
          {"drift_deg_per_s", or_null(errors.drift_deg_per_s)}};
}

ordered_json ToJson(const Consistency& consistency) {
  return {{"frames", consistency.frames},
          {"position_nees", NeesToJson(consistency.position)},
          {"pose_nees", NeesToJson(consistency.pose)}};
}

ordered_json ToJson(const TimeOffset& offset) {
  return {{"offset_s", offset.offset_s},
          {"sigma_s", offset.sigma_s},
          {"correlation", offset.correlation},
          {"unexplained", offset.unexplained},
          {"runner_up", offset.runner_up}};
}

ordered_json ToJson(const PathErrors& errors) {
  return {{"matched", errors.matched},
          {"expected", errors.expected},
          {"max_along_m", errors.max_along_m},
          {"max_across_m", errors.max_across_m},
          {"max_m", errors.max_m},
          {"rmse_m", errors.rmse_m}};
}

ordered_json ToJson(const Compensation& compensation) {
  const CompensationRatio& ratio = compensation.ratio;
  return {{"after", ToJson(compensation.after)},
          {"ratio",
           {{"max_along", ratio.max_along},
            {"max_across", ratio.max_across},
            {"max", ratio.max},
            {"rmse", ratio.rmse}}},
          {"tilt_error_deg",
           {{"pitch", ToJson(compensation.pitch_deg)}, {"roll", ToJson(compensation.roll_deg)}}}};
}

}  // namespace ceilmap::reports
