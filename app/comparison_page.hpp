#pragma once

#include <string>
#include <vector>

#include "app/comparison.hpp"
#include "app/comparison_figures.hpp"
#include "app/page/page_data.hpp"
#include "app/report_table.hpp"

namespace ceilmap::app {

/// What the page of `evaluate` shows, without a map: the truth, every run with positions beside it
/// and what it was without tilt compensation, errors over time and over the way, tables.
/// @param frame  all paths are shown in.
/// @param unit  of lengths, "m" or "px".
page::PageData ComparisonPage(const Comparison& comparison,
                              const std::vector<ReportTable>& tables,
                              ShownFrame frame,
                              const std::string& unit);

}  // namespace ceilmap::app
