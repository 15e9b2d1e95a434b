#pragma once

#include <map>
#include <string>

#include "mapping/graph/map_graph.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::store {

/// The layout of the map file that this program writes and the only one it reads.
inline constexpr int kMapFormatVersion = 2;

/// MapMetadata as the rows (key, value) of the table ceilmap_metadata. Numbers are written in the
/// shortest form that reads back to the same value, whatever the locale.
std::map<std::string, std::string> ToRows(const MapMetadata& metadata);

/// The opposite of ToRows. Unknown keys are ignored: a later minor version may add some.
/// @throws InputError (without the file's name) for another format version, a key that is
///   missing or a value that cannot be.
MapMetadata FromRows(const std::map<std::string, std::string>& rows);

/// MapQuality as rows of the same table.
std::map<std::string, std::string> ToRows(const graph::MapQuality& quality);
graph::MapQuality QualityFromRows(const std::map<std::string, std::string>& rows);

/// What is wrong with the metadata, empty when nothing is. Sizes beyond any camera or building
/// count as wrong, so that a damaged or hostile file cannot make a reader allocate without bound.
std::string Problem(const MapMetadata& metadata);
std::string Problem(const MosaicGrid& grid);

}  // namespace ceilmap::store
