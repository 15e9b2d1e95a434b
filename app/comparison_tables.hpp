#pragma once

#include <vector>

#include "app/comparison.hpp"
#include "app/report_table.hpp"

namespace ceilmap::app {

/// What `evaluate` tells people of a comparison: coverage, errors, errors over distances, headings,
/// and, where there is such a thing to tell, alignment, consistency, status and compensation.
std::vector<ReportTable> ComparisonTables(const Comparison& comparison);

}  // namespace ceilmap::app
