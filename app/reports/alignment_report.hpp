#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "app/reports/report_table.hpp"
#include "app/terminal/table.hpp"
#include "mapping/survey/alignment.hpp"

namespace ceilmap::reports {

/// The control points of an alignment: residuals in millimetres, and which of them are used.
ReportTable PointsTable(const survey::SiteFrame& site);

/// Where the map lies in its building, with standard deviations.
void AddSite(const survey::SiteFrame& site, terminal::Table& table);

/// All of an alignment as JSON.
nlohmann::ordered_json ToJson(const survey::SiteFrame& site);

/// What the result leaves in doubt, one line each: points that are not used, residuals larger than
/// their standard deviations, a scale other than 1, too few points to find a wrong one.
std::vector<std::string> WarningsOf(const survey::Alignment& alignment, const std::string& unit);

}  // namespace ceilmap::reports
