#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "mapping/map_match.hpp"

/// The file of a MapMatch (`.edges`), JSON:
///   {"format": "ceilmap edges", "version": 1,
///    "a": {"map": "east.gpkg", "fingerprint": "0123456789abcdef"}, "b": {...},
///    "verdict": "joined"|"no_overlap"|"ambiguous"|"contradicts", "reason": "",
///    "compared": 210, "expected": 24, "matched": 24,
///    "T_a_b": {"x": 1.5, "y": 0.25, "yaw_rad": 0.1},
///    "edges": [{"from": 3, "to": 8, "x": .., "y": .., "yaw_rad": .., "information": [6 numbers]}]}
/// T_a_b is null and edges is empty unless joined. The information is the upper triangle of the
/// symmetric matrix, row by row (MapMatch, graph::Edge). Numbers have the digits that give the same
/// double again.
namespace ceilmap::mapping {

/// Larger files are refused before they fill the memory: 400,000 edges.
inline constexpr std::size_t kMaxEdgesFileBytes = std::size_t{128} << 20U;

/// The content of the file.
std::string FormatEdges(const MapMatch& match);

/// Reads the content. @throws InputError in one line without the file's name, with the place in the
/// content and the remedy: unknown and missing fields, other types and values out of range.
MapMatch ParseEdges(const std::string& text);

/// Reads a file. @throws InputError with the file's name also when it is missing, too large or not
/// readable.
MapMatch ReadEdges(const std::filesystem::path& file);

/// "joined", "no_overlap", ...
const char* ToString(JoinResult::Verdict verdict);

}  // namespace ceilmap::mapping
