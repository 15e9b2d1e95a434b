#pragma once

#include <cstdint>
#include <vector>

#include "calib/ceiling_view.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/loop_closer.hpp"
#include "mapping/map_joiner.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mapping {

/// Adds `offset` to the ids of all keyframes, so that two maps can be merged.
void Renumber(graph::MapGraph& graph, std::int64_t offset);

/// Expresses an edge between other bases: p_own = T_own_new * p_new at each end.
void ChangeBases(graph::Edge& edge, const Pose2& T_own_new_from, const Pose2& T_own_new_to);

/// The same for a keyframe's pose and covariance.
void ChangeBase(graph::Keyframe& keyframe, const Pose2& T_own_new);

/// Changes the base of a graph's keyframes and edges to one from which the pose of the camera is
/// `T_base_view` instead of `T_base_view_own`, so that maps of differently mounted cameras can be
/// merged. Frames of the trajectory keep their own base.
void ChangeView(graph::MapGraph& graph, const Pose2& T_base_view_own, const Pose2& T_base_view);

/// Result of joining the parts of a map.
struct JoinedParts {
  std::vector<std::size_t> joined;  ///< indices of the joined parts, including the first one
  std::vector<JoinResult> results;  ///< for each part, the last attempt; the first one's is empty
  graph::LoopCounts loops;          ///< comparisons made to find the parts' relative poses
};

/// Joins parts to the first one, one after the other, as long as another part fits what is joined
/// already. The keyframes of a joined part are moved into the frame of the first, and closures are
/// searched for in the whole common area.
/// @param closer  holds the keyframes of all parts, and the edges within each.
JoinedParts JoinAll(LoopCloser& closer,
                    const std::vector<std::vector<std::int64_t>>& parts,
                    const DescriptorSource& descriptors,
                    JoinLight light = JoinLight::kOther);

struct MergeResult {
  graph::MapGraph graph;                 ///< of all joined parts, in the frame of the first
  std::vector<JoinResult> results;       ///< for each part, see JoinedParts
  store::MosaicGrid grid;                ///< of the mosaic that was written, if one was
  std::vector<store::LeftOut> left_out;  ///< what images show, but the mosaic does not
  [[nodiscard]] bool ok() const;         ///< true when every part was joined
};

/// Which poses a merge may change.
enum class HeldPoses {
  kFirstKeyframe,  ///< all but that of the first keyframe of the first part
  kFirstPart,      ///< those of the other parts; the first part stays to the last bit
};

/// Merges several maps into one. The keyframes' ids must differ between the parts (Renumber), and
/// their images must have the geometry of `view` (ChangeView). The first keyframe of the first part
/// keeps its pose, or all of that part do.
MergeResult MergeGraphs(const calib::CeilingView& view,
                        const std::vector<graph::MapGraph>& parts,
                        const graph::ImageLoader& load,
                        const DescriptorSource& descriptors,
                        const LoopCloserParams& loops = {},
                        const graph::PoseGraphParams& pose_graph = {},
                        HeldPoses held = HeldPoses::kFirstKeyframe);

}  // namespace ceilmap::mapping
