#pragma once

#include <map>
#include <string>

#include "mapping/graph/map_graph.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::store {

/// Version of the map file's format that this program writes, and the only one that it reads.
inline constexpr int kMapFormatVersion = 2;
/// Beginning of the keys of the alignment with the building.
inline constexpr char kSitePrefix[] = "site_";
inline constexpr char kProvenanceKey[] = "provenance";

/// MapMetadata as the rows (key, value) of the table ceilmap_metadata, with those of its site.
/// Numbers are written in the
/// shortest form that gives the same value when it is read, in any locale.
std::map<std::string, std::string> ToRows(const MapMetadata& metadata);

/// The inverse of ToRows. Unknown keys are ignored: a later minor version may add some.
/// @throws InputError (without the file's name) for another format version, a missing key or an
/// invalid value.
MapMetadata FromRows(const std::map<std::string, std::string>& rows);

/// The alignment with the building as rows of the same table, without its points.
std::map<std::string, std::string> ToRows(const survey::SiteFrame& site);

/// What a part of a mosaic has more than the metadata of its map.
std::map<std::string, std::string> ToRows(const MosaicPart& part);

/// MapQuality as rows of the same table.
std::map<std::string, std::string> ToRows(const graph::MapQuality& quality);
graph::MapQuality QualityFromRows(const std::map<std::string, std::string>& rows);

/// The problem of invalid metadata, empty when they are valid. Sizes beyond any camera or building
/// are invalid, so that a damaged or hostile file cannot cause unbounded allocation.
std::string Problem(const MapMetadata& metadata);
std::string Problem(const MosaicGrid& grid);

}  // namespace ceilmap::store
