#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "app/reports/report_table.hpp"
#include "app/terminal/table.hpp"
#include "localization/robot/map_updater.hpp"
#include "mapping/change/map_pruning.hpp"
#include "mapping/store/map_history.hpp"

namespace ceilmap::reports {

/// Middle of the box around a change.
cv::Point2d MiddleOf(const store::Change& change);

/// What an update found and did.
terminal::Table FactsOf(const robot::MapUpdateReport& report);
nlohmann::ordered_json ToJson(const robot::MapUpdateReport& report);

/// What was removed from a map.
terminal::Table FactsOf(const change::PruneReport& report);
nlohmann::ordered_json ToJson(const change::PruneReport& report);

/// The recordings of a map, a row each.
ReportTable SessionsTable(const store::MapHistory& history);
/// What has changed, a row each.
ReportTable ChangesTable(const std::vector<store::Change>& changes);
nlohmann::ordered_json ToJson(const store::MapHistory& history);
nlohmann::ordered_json ToJson(const store::Change& change);

}  // namespace ceilmap::reports
