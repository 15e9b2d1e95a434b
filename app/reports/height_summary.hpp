#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::reports {

/// Heights of a map in figures.
struct HeightSummary {
  std::size_t keyframes = 0;  ///< that have heights; in the others the ceiling is plane
  /// Of the measured cells of all keyframes: 1st and 99th percentile, metres above the floor;
  /// nothing without a measured cell or without a rig.
  std::optional<double> lowest_m;
  std::optional<double> highest_m;
};

HeightSummary SummarizeHeights(const std::vector<graph::Keyframe>& keyframes,
                               const store::MapMetadata& metadata);

/// As a line of a table.
std::string Describe(const HeightSummary& heights);
/// `keyframes`, `lowest_m`, `highest_m`; null where there is none.
nlohmann::ordered_json ToJson(const HeightSummary& heights);

}  // namespace ceilmap::reports
