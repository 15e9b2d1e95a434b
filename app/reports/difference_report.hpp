#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "app/page/page_data.hpp"
#include "app/reports/report_table.hpp"
#include "app/terminal/table.hpp"
#include "mapping/change/map_difference.hpp"
#include "mapping/placed_maps.hpp"

namespace ceilmap::reports {

/// Two maps of one ceiling that were compared.
struct ComparedMaps {
  mapping::NamedMap before;
  mapping::NamedMap after;
  mapping::PlacedKeyframes placed;
  change::MapDifference difference;
};

/// What was compared, and how much differs.
terminal::Table FactsOf(const ComparedMaps& compared);
/// The changes, a row each. @param unit  of the first map.
ReportTable DifferenceTable(const change::MapDifference& difference, const std::string& unit);
nlohmann::ordered_json ToJson(const ComparedMaps& compared);
/// The changes as CSV: id,kind,x,y,area,difference,wkt, in the frame of the first map.
std::string DifferenceCsv(const change::MapDifference& difference);
/// A page with both mosaics on the two sides of a divider, and the changes.
/// @throws InputError as MapReader.
page::PageData DifferencePage(const ComparedMaps& compared);

}  // namespace ceilmap::reports
