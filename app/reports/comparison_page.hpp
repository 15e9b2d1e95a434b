#pragma once

#include <string>
#include <vector>

#include "app/page/page_data.hpp"
#include "app/reports/comparison.hpp"
#include "app/reports/comparison_figures.hpp"
#include "app/reports/report_table.hpp"

namespace ceilmap::reports {

/// What the page of `evaluate` shows, without a map: the truth, every run with positions beside it
/// and what it was without tilt compensation, errors over time and over the way, tables.
/// @param frame  all paths are shown in.
/// @param unit  of lengths, "m" or "px".
page::PageData ComparisonPage(const Comparison& comparison,
                              const std::vector<ReportTable>& tables,
                              ShownFrame frame,
                              const std::string& unit);

}  // namespace ceilmap::reports
