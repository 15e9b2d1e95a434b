#pragma once

#include <cstdint>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/loop_closer.hpp"
#include "mapping/map_joiner.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mapping {

/// Adds `offset` to the ids of all keyframes, so that two maps can come together.
void Renumber(graph::MapGraph& graph, std::int64_t offset);

/// Lets a graph's keyframes and edges refer to a base from which the camera is seen at
/// `T_base_view` instead of `T_base_view_own`, so that maps of cameras that are mounted differently
/// come together. Frames of the trajectory keep their own base.
void ChangeView(graph::MapGraph& graph, const Pose2& T_base_view_own, const Pose2& T_base_view);

/// What became of the parts of a map.
struct JoinedParts {
  std::vector<std::size_t> joined;  ///< indices of the parts; the first one and what joined it
  std::vector<JoinResult> results;  ///< for each part, the last attempt; the first one's is empty
  graph::LoopCounts loops;          ///< images compared to find how the parts lie
};

/// Joins parts to the first one, one after the other, as long as one more fits to what is joined
/// already; their keyframes are moved there, and closures are looked for all over the common area.
/// @param closer  holds the keyframes of all parts, and the edges within each.
JoinedParts JoinAll(LoopCloser& closer,
                    const std::vector<std::vector<std::int64_t>>& parts,
                    const DescriptorSource& descriptors,
                    const JoinParams& params = {});

struct MergeParams {
  LoopCloserParams loops;
  JoinParams join;
  graph::OptimizeParams optimize;
  /// Of the closures between joined parts, at the most this part may turn out to contradict the
  /// rest.
  double max_outlier_ratio = 0.3;
};

struct MergeResult {
  graph::MapGraph graph;            ///< of all parts that were joined, in the frame of the first
  std::vector<JoinResult> results;  ///< for each part, see JoinedParts
  store::MosaicGrid grid;           ///< of the mosaic that was written, if one was
  [[nodiscard]] bool ok() const;    ///< every part was joined
};

/// Makes one map of several. The keyframes' ids must differ between the parts (Renumber) and their
/// images have the geometry of `view` (ChangeView). The first keyframe of the first part keeps
/// its pose.
MergeResult MergeGraphs(const calib::CeilingView& view,
                        const std::vector<graph::MapGraph>& parts,
                        const graph::ImageLoader& load,
                        const DescriptorSource& descriptors,
                        const MergeParams& params = {});

}  // namespace ceilmap::mapping
