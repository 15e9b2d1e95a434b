#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/evaluation/compensation.hpp"
#include "app/reports/report_table.hpp"

namespace ceilmap::reports {

/// How `evaluate --before` tells of a compensation: centimetres and degrees for people, metres and
/// degrees in files.

struct NamedCompensation {
  std::string name;
  evaluation::Compensation compensation;
};

/// Two tables with a row per estimate: largest errors along and across the path and root mean
/// square, before and after; errors of the estimated tilt.
std::vector<ReportTable> CompensationTables(const std::vector<NamedCompensation>& rows);

/// The first of them as CSV: `estimate` and, for along, across and rmse, `*_before_m,*_m,*_ratio`;
/// then the tilt's errors.
std::string FormatTableCsv(const std::vector<NamedCompensation>& rows);

/// Of one pose of the truth, in the frame of the truth: the names of its columns, and its fields.
/// What an estimate does not have is empty.
std::string_view CompensatedFrameColumns();
std::string FormatCompensatedFrame(const evaluation::CompensatedFrame& frame);

}  // namespace ceilmap::reports
