#pragma once

#include <functional>
#include <vector>

#include "mapping/graph/map_graph.hpp"
#include "mapping/mosaic/mosaic.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

struct WrittenMap {
  store::MosaicGrid grid;                ///< of the mosaic
  std::vector<store::LeftOut> left_out;  ///< what images show, but the mosaic does not
};

/// Writes a graph and the mosaic rendered from its keyframes' images (without Commit). The images
/// must be in the writer already.
/// @param progress  done, total windows of the mosaic; may be empty.
WrittenMap WriteMap(const graph::MapGraph& graph,
                    const store::MapMetadata& metadata,
                    const MosaicParams& mosaic,
                    store::MapWriter& writer,
                    const std::function<void(int, int)>& progress = {});

/// Writes what a renderer draws (without Commit): the mosaic, and what it leaves out.
WrittenMap WriteMosaic(const MosaicRenderer& renderer,
                       store::MapWriter& writer,
                       const std::function<void(int, int)>& progress = {});

/// The mask of the views and, unless it is set, the resolution are those of the map.
MosaicParams ParamsFor(const store::MapMetadata& metadata, MosaicParams params = {});

}  // namespace ceilmap::mosaic
