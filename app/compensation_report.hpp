#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/evaluation/compensation.hpp"

namespace ceilmap::app {

/// How `evaluate --before` tells of a compensation: centimetres and degrees for people, metres and
/// degrees in files.

struct NamedCompensation {
  std::string name;
  evaluation::Compensation compensation;
};

/// Two tables with a row per estimate: largest errors along and across the path and root mean
/// square, before and after; errors of the estimated tilt.
std::string FormatTables(const std::vector<NamedCompensation>& rows);

/// The first of them as CSV: `estimate` and, for along, across and rmse, `*_before_m,*_m,*_ratio`;
/// then the tilt's errors.
std::string FormatTableCsv(const std::vector<NamedCompensation>& rows);

/// A line for each pose of the truth, in the frame of the truth. What an estimate does not have is
/// empty.
std::string FormatFramesCsv(const evaluation::Compensation& compensation);

nlohmann::ordered_json ToJson(const evaluation::ErrorStatistics& statistics);
nlohmann::ordered_json ToJson(const evaluation::PathErrors& errors);
/// Of one estimate: after, ratio, tilt_error_deg.
nlohmann::ordered_json ToJson(const evaluation::Compensation& compensation);

}  // namespace ceilmap::app
