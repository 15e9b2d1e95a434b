#pragma once

#include <nlohmann/json.hpp>

#include "mapping/map_graph.hpp"

namespace ceilmap::app {

/// For --summary and `info --json`: compared, accepted (and kept), and the reasons why the others
/// were not.
nlohmann::ordered_json ToJson(const mapping::LoopCounts& loops);

}  // namespace ceilmap::app
