#pragma once

#include <string>

namespace ceilmap::store {

/// The coordinate reference system of a text as WKT 2: "EPSG:25832", WKT, or a PROJ string. Nothing
/// is fetched from a network or a file.
/// @throws InputError unless it is known, and projected or local with the metre as its unit.
std::string ParseCrs(const std::string& text);

/// The name of a system in WKT, e.g. "ETRS89 / UTM zone 32N"; "local" for an empty text.
std::string NameOfCrs(const std::string& wkt);

}  // namespace ceilmap::store
