#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/terminal/table.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::reports {

/// For --summary and `info --json`: compared and accepted loop closures (and those kept), and the
/// numbers of rejected ones by reason.
nlohmann::ordered_json ToJson(const graph::LoopCounts& loops);
/// Loops and residuals.
nlohmann::ordered_json ToJson(const graph::MapQuality& quality);
nlohmann::ordered_json ToJson(const std::vector<graph::WeakSpot>& spots);

/// `kind` and `area` of each, without the outlines.
nlohmann::ordered_json ToJson(const std::vector<store::LeftOut>& places);
/// What is left out of a map, in one line: "12.3 m^2 where walls or furniture
/// hide the ceiling".
std::string Describe(const std::vector<store::LeftOut>& places, const std::string& unit);

/// Describes a weak spot in one line. @param unit  Of the map, "m" or "px".
std::string Describe(const graph::WeakSpot& spot, const std::string& unit);

/// Table rows: loop closures by result, residuals, and at most `max_spots` weak spots, the largest
/// first.
void AddQuality(const graph::MapQuality& quality,
                std::vector<graph::WeakSpot> spots,
                const std::string& unit,
                int max_spots,
                terminal::Table& table);

}  // namespace ceilmap::reports
