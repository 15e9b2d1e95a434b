#pragma once

#include <functional>

#include "mapping/map_file.hpp"
#include "mapping/map_graph.hpp"
#include "mapping/mosaic.hpp"

namespace ceilmap::mapping {

/// Writes a graph, whose keyframes' pictures are in the writer already, and the mosaic that they
/// make (without Commit).
/// @param progress  done, total windows of the mosaic; may be empty.
/// @return the extent of the mosaic.
MosaicGrid WriteMap(const MapGraph& graph,
                    const MapMetadata& metadata,
                    const MosaicParams& mosaic,
                    MapWriter& writer,
                    const std::function<void(int, int)>& progress = {});

}  // namespace ceilmap::mapping
