#pragma once

#include <functional>
#include <vector>

#include "mapping/map_merge.hpp"
#include "mapping/mapper.hpp"
#include "mapping/mosaic/mosaic.hpp"
#include "mapping/store/map_file.hpp"

/// Several maps in one file.
namespace ceilmap::mapping {

struct UnionParams {
  MergeParams merge;
  mosaic::MosaicParams mosaic;
};

/// Progress of the mosaic: done, total windows.
using UnionProgress = std::function<void(int, int)>;

/// The geometry of a map's images.
calib::CeilingView ViewOf(const store::MapMetadata& metadata);

/// Why images of the two maps cannot stand in one, in words; empty when they can. Different
/// mountings do not matter, different scales and image sizes do.
std::string Incompatibility(const store::MapMetadata& a, const store::MapMetadata& b);

/// Writes the union of maps to the writer (without Commit), in the frame of the first; nothing is
/// written unless every map could be joined (`ok()`).
/// @param writer  made with the metadata that the union shall have.
/// @throws InputError when a map is incompatible with the first.
MergeResult MergeMaps(const std::vector<const store::MapReader*>& maps,
                      const store::MapMetadata& metadata,
                      const UnionParams& params,
                      store::MapWriter& writer,
                      const UnionProgress& progress = {});

/// The same for a map and a recording that was mapped just now into `writer`, whose first keyframe
/// id is past the map's last one.
/// @param recording  of the closed Mapper, seen with `recording_view`.
MergeResult AppendRecording(const store::MapReader& map,
                            const graph::MapGraph& recording,
                            const calib::CeilingView& recording_view,
                            const store::MapMetadata& metadata,
                            const UnionParams& params,
                            store::MapWriter& writer,
                            const UnionProgress& progress = {});

}  // namespace ceilmap::mapping
