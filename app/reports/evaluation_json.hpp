#pragma once

#include <nlohmann/json.hpp>

#include "app/evaluation/compensation.hpp"
#include "app/evaluation/consistency.hpp"
#include "app/evaluation/heading_errors.hpp"
#include "app/evaluation/time_offset.hpp"
#include "app/evaluation/trajectory_errors.hpp"

namespace ceilmap::reports {

/// Errors as JSON, with units in the keys; app/evaluation/README.md defines them. Keys never change
/// their name or meaning, because scripts read them.

nlohmann::ordered_json ToJson(const evaluation::ErrorStatistics& statistics);
nlohmann::ordered_json ToJson(const evaluation::PoseErrorStatistics& statistics);
/// x, y, yaw_deg, scale.
nlohmann::ordered_json ToJson(const Similarity2& T);
nlohmann::ordered_json ToJson(const evaluation::SegmentErrors& errors);
/// Without the errors of single frames.
nlohmann::ordered_json ToJson(const evaluation::TrajectoryErrors& errors);
nlohmann::ordered_json ToJson(const evaluation::HeadingErrors& errors);
nlohmann::ordered_json ToJson(const evaluation::Consistency& consistency);
nlohmann::ordered_json ToJson(const evaluation::TimeOffset& offset);
nlohmann::ordered_json ToJson(const evaluation::PathErrors& errors);
/// For one estimate: after, ratio, tilt_error_deg.
nlohmann::ordered_json ToJson(const evaluation::Compensation& compensation);

}  // namespace ceilmap::reports
