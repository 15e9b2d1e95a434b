#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/evaluation/compensation.hpp"
#include "app/reports/report_table.hpp"

namespace ceilmap::reports {

/// Results of a compensation by `evaluate --before`: centimetres and degrees in tables, metres and
/// degrees in files.

struct NamedCompensation {
  std::string name;
  evaluation::Compensation compensation;
};

/// Two tables with one row per estimate: largest errors along and across the path and root mean
/// square, before and after compensation; errors of the estimated tilt.
std::vector<ReportTable> CompensationTables(const std::vector<NamedCompensation>& rows);

/// The first of them as CSV: `estimate` and, for along, across and rmse, `*_before_m,*_m,*_ratio`;
/// then the errors of the tilt.
std::string FormatTableCsv(const std::vector<NamedCompensation>& rows);

/// For one pose of the truth, in the frame of the truth: column names, and fields. Unavailable
/// values are empty.
std::string_view CompensatedFrameColumns();
std::string FormatCompensatedFrame(const evaluation::CompensatedFrame& frame);

}  // namespace ceilmap::reports
