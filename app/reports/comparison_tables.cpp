#include "app/reports/comparison_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "calib/base/degrees.hpp"

namespace ceilmap::reports {
namespace {

using evaluation::ErrorStatistics;

// Without values there is no ratio.
std::string Fixed(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.find_first_not_of("-0.") == std::string::npos) std::erase(text, '-');
  return text;
}

std::string FixedOrNothing(const std::optional<double>& value, int decimals) {
  return value ? Fixed(*value, decimals) : "";
}

ReportTable CoverageTable(const Comparison& comparison) {
  ReportTable table{"Coverage", {"estimate", "poses", "of", "coverage", "path m"}, {}};
  for (const ComparedEstimate& estimate : comparison.estimates) {
    const double path_m = estimate.errors ? estimate.errors->path_m : estimate.heading.path_m;
    table.rows.push_back({estimate.file.name,
                          fmt::to_string(estimate.matched),
                          fmt::to_string(estimate.expected),
                          Fixed(estimate.Coverage(), 4),
                          Fixed(path_m, 3)});
  }
  return table;
}

ReportTable ErrorTable(const Comparison& comparison) {
  ReportTable table{
      "Errors", {"estimate", "error", "unit", "rmse", "mean", "median", "std", "p95", "max"}, {}};
  for (const ComparedEstimate& estimate : comparison.estimates) {
    const auto add = [&](const char* error, const char* unit, const ErrorStatistics& s) {
      std::vector<std::string> row = {estimate.file.name, error, unit};
      for (const double value : {s.rmse, s.mean, s.median, s.std, s.p95, s.max}) {
        row.push_back(Fixed(value, 5));
      }
      table.rows.push_back(std::move(row));
    };
    if (!estimate.errors) {
      add("heading", "deg", estimate.heading.error_deg);
      continue;
    }
    const evaluation::TrajectoryErrors& errors = *estimate.errors;
    add("position", "m", errors.position_m);
    add("yaw", "deg", errors.yaw_deg);
    if (errors.tilted) {
      add("position in space", "m", errors.pose.translation_m);
      add("rotation in space", "deg", errors.pose.rotation_deg);
    }
    if (errors.per_metre_m) add("position per metre", "m", *errors.per_metre_m);
    if (errors.per_metre_yaw_deg) add("yaw per metre", "deg", *errors.per_metre_yaw_deg);
    if (!errors.per_frame) continue;
    add("position per frame", "m", errors.per_frame->translation_m);
    add("rotation per frame", "deg", errors.per_frame->rotation_deg);
  }
  return table;
}

ReportTable AlignmentTable(const Comparison& comparison) {
  ReportTable table{"Alignment of the estimates with the truth",
                    {"estimate", "x m", "y m", "yaw deg", "scale", "offset s", "sigma s"},
                    {}};
  for (const ComparedEstimate& estimate : comparison.estimates) {
    std::vector<std::string> row = {estimate.file.name, "", "", "", ""};
    if (estimate.errors) {
      const Similarity2& T = estimate.errors->T_truth_estimate;
      row = {estimate.file.name,
             Fixed(T.motion.x, 4),
             Fixed(T.motion.y, 4),
             Fixed(kDegPerRad * T.motion.yaw, 3),
             Fixed(T.scale, 6)};
    }
    row.push_back(Fixed(estimate.offset_s, 4));
    row.push_back(estimate.found_offset ? Fixed(estimate.found_offset->sigma_s, 4) : "");
    table.rows.push_back(std::move(row));
  }
  return table;
}

ReportTable SegmentTable(const Comparison& comparison) {
  ReportTable table{
      "Errors of the motion over a distance",
      {"estimate", "metres", "starts", "translation %", "p95", "rotation deg/m", "p95"},
      {}};
  for (const ComparedEstimate& estimate : comparison.estimates) {
    if (!estimate.errors) continue;
    for (const evaluation::SegmentErrors& segment : estimate.errors->segments) {
      table.rows.push_back({estimate.file.name,
                            fmt::format("{:g}", segment.length_m),
                            fmt::to_string(segment.translation_percent.count),
                            Fixed(segment.translation_percent.mean, 4),
                            Fixed(segment.translation_percent.p95, 4),
                            Fixed(segment.rotation_deg_per_m.mean, 4),
                            Fixed(segment.rotation_deg_per_m.p95, 4)});
    }
  }
  return table;
}

ReportTable HeadingTable(const Comparison& comparison) {
  ReportTable table{"Heading relative to the first compared frame",
                    {"heading",
                     "path m",
                     "turned deg",
                     "max deg",
                     "rms deg",
                     "end deg",
                     "drift deg/m",
                     "drift deg/s"},
                    {}};
  for (const ComparedEstimate& estimate : comparison.estimates) {
    const evaluation::HeadingErrors& heading = estimate.heading;
    table.rows.push_back({estimate.file.name,
                          Fixed(heading.path_m, 3),
                          Fixed(heading.turned_deg, 1),
                          Fixed(heading.error_deg.max, 3),
                          Fixed(heading.error_deg.rmse, 3),
                          Fixed(heading.end_deg, 3),
                          FixedOrNothing(heading.drift_deg_per_m, 4),
                          FixedOrNothing(heading.drift_deg_per_s, 4)});
  }
  return table;
}

ReportTable ConsistencyTable(const Comparison& comparison) {
  ReportTable table{"Consistency of errors and covariances",
                    {"consistency",
                     "poses",
                     "NEES x y",
                     "expected",
                     "in 95 %",
                     "NEES x y yaw",
                     "expected",
                     "in 95 %"},
                    {}};
  for (const ComparedEstimate& estimate : comparison.estimates) {
    if (!estimate.consistency) continue;
    const evaluation::Nees& position = estimate.consistency->position;
    const evaluation::Nees& pose = estimate.consistency->pose;
    table.rows.push_back({estimate.file.name,
                          fmt::to_string(estimate.consistency->frames),
                          Fixed(position.mean, 3),
                          fmt::format("{:g}", position.expected),
                          Fixed(100 * position.inside_95, 1),
                          Fixed(pose.mean, 3),
                          fmt::format("{:g}", pose.expected),
                          Fixed(100 * pose.inside_95, 1)});
  }
  return table;
}

ReportTable StatusTable(const Comparison& comparison) {
  std::set<std::string> statuses;
  for (const ComparedEstimate& estimate : comparison.estimates) {
    for (const auto& [status, frames] : estimate.frames_of_status) statuses.insert(status);
  }
  ReportTable table{"Frames by status", {"status"}, {}};
  table.columns.insert(table.columns.end(), statuses.begin(), statuses.end());
  for (const ComparedEstimate& estimate : comparison.estimates) {
    if (estimate.frames_of_status.empty()) continue;
    std::vector<std::string> row = {estimate.file.name};
    for (const std::string& status : statuses) {
      const auto found = estimate.frames_of_status.find(status);
      row.push_back(fmt::to_string(found == estimate.frames_of_status.end() ? 0 : found->second));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

bool IsAlignmentWorthATable(const ComparedEstimate& estimate) {
  return estimate.offset_s != 0 ||
         (estimate.errors && estimate.errors->T_truth_estimate.scale != 1);
}

}  // namespace

std::vector<ReportTable> ComparisonTables(const Comparison& comparison) {
  std::vector<ReportTable> tables = {CoverageTable(comparison), ErrorTable(comparison)};
  const auto& estimates = comparison.estimates;
  if (std::any_of(estimates.begin(), estimates.end(), IsAlignmentWorthATable)) {
    tables.push_back(AlignmentTable(comparison));
  }
  for (ReportTable table : {SegmentTable(comparison),
                            HeadingTable(comparison),
                            ConsistencyTable(comparison),
                            StatusTable(comparison)}) {
    if (!table.rows.empty()) tables.push_back(std::move(table));
  }
  if (comparison.compensation) {
    for (ReportTable& table : CompensationTables(comparison.compensation->estimates)) {
      tables.push_back(std::move(table));
    }
  }
  return tables;
}

}  // namespace ceilmap::reports
