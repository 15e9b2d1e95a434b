#pragma once

#include <vector>

#include "app/reports/comparison.hpp"
#include "app/reports/report_table.hpp"

namespace ceilmap::reports {

/// What `evaluate` tells people of a comparison: coverage, errors, errors over distances, headings,
/// and, where there is such a thing to tell, alignment, consistency, status and compensation.
std::vector<ReportTable> ComparisonTables(const Comparison& comparison);

}  // namespace ceilmap::reports
