#pragma once

#include <functional>
#include <vector>

#include "mapping/map_merge.hpp"
#include "mapping/mapper.hpp"
#include "mapping/mosaic/mosaic.hpp"
#include "mapping/store/map_file.hpp"

/// Merges several maps into one file.
namespace ceilmap::mapping {

/// Progress of the mosaic: done, total windows.
using UnionProgress = std::function<void(int, int)>;

/// The geometry of a map's images.
calib::CeilingView ViewOf(const store::MapMetadata& metadata);

/// Why images of the two maps cannot be used in one map, as a readable message; empty when they
/// can. Different mountings are allowed; different scales, focal lengths and image sizes are not.
std::string Incompatibility(const store::MapMetadata& a, const store::MapMetadata& b);

/// Writes the union of maps, in the frame of the first, to the writer (without Commit). Nothing is
/// written unless every map could be joined (`ok()`).
/// @param params  those of the odometry and the origin are not used. @param writer  made with the
/// metadata of the union.
/// @throws InputError when a map is incompatible with the first.
MergeResult MergeMaps(const std::vector<const store::MapReader*>& maps,
                      const store::MapMetadata& metadata,
                      const MapperParams& params,
                      store::MapWriter& writer,
                      const UnionProgress& progress = {});

/// The same for a map and a recording that was just mapped into `writer`. The first keyframe id of
/// the recording is larger than the last one of the map.
/// @param recording  graph of the closed Mapper, recorded with `recording_view`.
MergeResult AppendRecording(const store::MapReader& map,
                            const graph::MapGraph& recording,
                            const calib::CeilingView& recording_view,
                            const store::MapMetadata& metadata,
                            const MapperParams& params,
                            store::MapWriter& writer,
                            const UnionProgress& progress = {});

}  // namespace ceilmap::mapping
