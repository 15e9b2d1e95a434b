#pragma once

#include <vector>

#include "app/reports/comparison.hpp"
#include "app/reports/report_table.hpp"

namespace ceilmap::reports {

/// Tables of a comparison by `evaluate`: coverage, errors, errors over distances, headings, and, if
/// available, alignment, consistency, status and compensation.
std::vector<ReportTable> ComparisonTables(const Comparison& comparison);

}  // namespace ceilmap::reports
