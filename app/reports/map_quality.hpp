#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/terminal/table.hpp"
#include "mapping/graph/map_graph.hpp"

namespace ceilmap::reports {

/// For --summary and `info --json`: compared, accepted (and kept), and the reasons why the others
/// were not.
nlohmann::ordered_json ToJson(const graph::LoopCounts& loops);
/// Loops and residuals.
nlohmann::ordered_json ToJson(const graph::MapQuality& quality);
nlohmann::ordered_json ToJson(const std::vector<graph::WeakSpot>& spots);

/// What is the matter there, in one line. @param unit  of the map, "m" or "px".
std::string Describe(const graph::WeakSpot& spot, const std::string& unit);

/// Rows for people: loops by what became of them, residuals, and the weak spots, the largest first
/// and no more than `max_spots`.
void AddQuality(const graph::MapQuality& quality,
                std::vector<graph::WeakSpot> spots,
                const std::string& unit,
                int max_spots,
                terminal::Table& table);

}  // namespace ceilmap::reports
