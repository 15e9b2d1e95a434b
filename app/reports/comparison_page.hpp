#pragma once

#include <string>
#include <vector>

#include "app/page/page_data.hpp"
#include "app/reports/comparison.hpp"
#include "app/reports/comparison_figures.hpp"
#include "app/reports/report_table.hpp"

namespace ceilmap::reports {

/// Content of the page of `evaluate`, without a map: the truth, every run with positions, the run
/// without tilt compensation, errors over time and over the distance travelled, tables.
/// @param frame  Of all paths. @param unit  Of lengths, "m" or "px".
/// @param S_page_run  With kFirstRun: from the frame of the first run to that of the page.
page::PageData ComparisonPage(const Comparison& comparison,
                              const std::vector<ReportTable>& tables,
                              ShownFrame frame,
                              const std::string& unit,
                              const Similarity2& S_page_run = {});

}  // namespace ceilmap::reports
