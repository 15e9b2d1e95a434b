#pragma once

#include <filesystem>
#include <string>

#include "mapping/survey/site_frame.hpp"

namespace ceilmap::store {

/// Writes a copy of a map that is aligned with its building: metadata `site_*` and the layer
/// `control_points`. An earlier alignment is replaced. Everything else stays as it is. Like
/// MapWriter, the result appears complete or not at all.
/// @param output  May be the map itself. @param provenance  Added to that of the map.
/// @throws InputError as MapReader, for a map on a server, and when the map is changed meanwhile;
/// RunError when the disk cannot be written.
void WriteSiteFrame(const std::filesystem::path& map,
                    const std::filesystem::path& output,
                    const survey::SiteFrame& site,
                    const std::string& provenance);

}  // namespace ceilmap::store
