#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/table.hpp"
#include "mapping/map_graph.hpp"

namespace ceilmap::app {

/// For --summary and `info --json`: compared, accepted (and kept), and the reasons why the others
/// were not.
nlohmann::ordered_json ToJson(const mapping::LoopCounts& loops);
/// Loops and residuals.
nlohmann::ordered_json ToJson(const mapping::MapQuality& quality);
nlohmann::ordered_json ToJson(const std::vector<mapping::WeakSpot>& spots);

/// What is the matter there, in one line. @param unit  of the map, "m" or "px".
std::string Describe(const mapping::WeakSpot& spot, const std::string& unit);

/// Rows for people: loops by what became of them, residuals, and the weak spots, the largest first
/// and no more than `most_spots`.
void AddQuality(const mapping::MapQuality& quality,
                std::vector<mapping::WeakSpot> spots,
                const std::string& unit,
                int most_spots,
                Table& table);

}  // namespace ceilmap::app
