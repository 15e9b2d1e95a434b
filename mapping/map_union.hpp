#pragma once

#include <functional>
#include <vector>

#include "mapping/common_view.hpp"
#include "mapping/map_merge.hpp"
#include "mapping/mapper.hpp"
#include "mapping/mosaic/map_builder.hpp"
#include "mapping/store/map_file.hpp"

/// Merges several maps into one file.
namespace ceilmap::mapping {

/// Progress of the mosaic: done, total windows.
using UnionProgress = std::function<void(int, int)>;

/// Writes a graph over keyframes of several maps, and its mosaic (without Commit).
/// @param write_image  Stores image and descriptors of a keyframe in the writer.
/// @param params  mosaic: how the mosaic is rendered.
mosaic::WrittenMap WriteUnion(const graph::MapGraph& graph,
                              const std::function<void(std::int64_t)>& write_image,
                              const store::MapMetadata& metadata,
                              const MapperParams& params,
                              store::MapWriter& writer,
                              const UnionProgress& progress = {});

/// Writes the union of maps, in the frame of the first, to the writer (without Commit). Nothing is
/// written unless every map could be joined (`ok()`).
/// @param view  of these maps. @param metadata  of the union: those of the view, with another
/// resolution and provenance. @param params  those of the odometry and the origin are not used.
/// @param writer  made with `metadata`.
MergeResult MergeMaps(const std::vector<NamedMap>& maps,
                      const CommonView& view,
                      const store::MapMetadata& metadata,
                      const MapperParams& params,
                      store::MapWriter& writer,
                      const UnionProgress& progress = {});

/// The same for a map and a recording that was just mapped into `writer`, with images of the same
/// geometry (Incompatibility). The first keyframe id of the recording is larger than the last one
/// of the map.
/// @param recording  graph of the closed Mapper, recorded with `recording_view`.
MergeResult AppendRecording(const store::MapReader& map,
                            const graph::MapGraph& recording,
                            const calib::CeilingView& recording_view,
                            const store::MapMetadata& metadata,
                            const MapperParams& params,
                            store::MapWriter& writer,
                            const UnionProgress& progress = {},
                            HeldPoses held = HeldPoses::kFirstKeyframe);

}  // namespace ceilmap::mapping
