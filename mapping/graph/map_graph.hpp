#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/pose_graph.hpp"

/// A map without its images: the poses, the measurements that determine them, and their quality.
namespace ceilmap::graph {

/// Results of the comparisons for loop closures.
struct LoopCounts {
  std::int64_t compared = 0;        ///< pairs of keyframes that were registered
  std::int64_t accepted = 0;        ///< became edges of the graph
  std::int64_t no_match = 0;        ///< the images do not agree, or have no texture
  std::int64_t ambiguous = 0;       ///< several motions fit (periodic ceiling): rejected
  std::int64_t off_prediction = 0;  ///< agree, but on a motion that contradicts the rest of the map
  /// Agree, but the prediction was uncertain and only one pair supports it.
  std::int64_t unconfirmed = 0;
  std::int64_t outliers = 0;  ///< accepted closures that the pose graph removed again

  LoopCounts& operator+=(const LoopCounts& other);
};

/// Consistency of a map's measurements with each other.
struct MapQuality {
  LoopCounts loops;
  /// Mean squared residual of the edges in units of their covariance, per degree of freedom of the
  /// graph: 1 where the covariances of the measurements are right.
  double chi2_per_dof = 0;
  double max_edge_sigmas = 0;  ///< largest residual of a remaining edge
  double odometry_rms = 0;  ///< residuals of translations, root mean square of an axis, map units
  double loop_rms = 0;
};

/// A place where the map is less reliable.
struct WeakSpot {
  enum class Kind {
    /// Several motions explain the images here: the ceiling is repetitive. extent: length of this
    /// part of the path, map units.
    kAmbiguous,
    kLost,      ///< frames could not be placed here; extent: their number
    kUnclosed,  ///< the path has no loop closure here; extent: its length in map units
  };
  Kind kind = Kind::kAmbiguous;
  std::int64_t keyframe_id = -1;  ///< nearest in time, or the middle one
  double x = 0;                   ///< in the map
  double y = 0;
  double extent = 0;
};
const char* ToString(WeakSpot::Kind kind);

struct MapGraph {
  /// Without images; in order of increasing ids, which may have gaps.
  std::vector<Keyframe> keyframes;
  std::vector<Edge> edges;
  std::vector<FramePose> trajectory;  ///< in order of time for each recording
  std::vector<WeakSpot> weak_spots;
  MapQuality quality;
};

/// Poses of the keyframes by id, for OptimizePoses.
std::vector<Pose2> PosesById(const MapGraph& graph);

/// Moves the keyframes to `poses` (by id). Each frame of the trajectory moves with its keyframe;
/// where the next keyframe moves otherwise, the frames between the two share the difference.
/// Covariances are rotated with the keyframe.
void MoveKeyframes(MapGraph& graph, const std::vector<Pose2>& poses);

/// Length of the path through the frames, map units; gaps count as straight lines.
double PathLength(const std::vector<FramePose>& trajectory);

/// The keyframes' ids by connected components of the graph, largest component first, equal ones by
/// age.
std::vector<std::vector<std::int64_t>> Components(const MapGraph& graph);

/// Removes all other keyframes, with their edges, frames and weak spots.
void KeepOnly(MapGraph& graph, const std::unordered_set<std::int64_t>& keyframe_ids);

/// Moves the whole map: T_new_base = T_new_old * T_old_base, and rotates covariances with it.
void MoveAll(MapGraph& graph, const Pose2& T_new_old);

/// Multiplies all distances of the map, as the camera measured them, by a factor > 0; heights that
/// are relative to the reference plane are divided by it.
/// @param T_base_view  CeilingView::T_base_view: rotations about the base move the camera by
/// distances that are known.
void Scale(MapGraph& graph, double factor, const Pose2& T_base_view);

/// The same for the motions that were measured against each keyframe, and for its heights. What
/// wheels measured stays. The first keyframe stays; each other one moves with the one before it, so
/// that keyframes and frames remain at the same places between each other until the graph is
/// optimized.
/// @param factors  by keyframe id, > 0; keyframes without an entry stay as they are.
void ScaleMotions(MapGraph& graph,
                  const std::unordered_map<std::int64_t, double>& factors,
                  const Pose2& T_base_view);

/// Computes the most likely poses of all keyframes given all edges, with the first keyframe fixed.
/// Loop closures that contradict the rest are removed (quality.loops.outliers). Then computes the
/// covariances of keyframes and frames relative to the first keyframe, scaled up where the
/// residuals are larger than the edges' covariances, and the figures of `quality`.
///
/// Every keyframe must be connected with the first by edges.
/// @param held  keyframes that keep their poses in place of the first one; covariances are then
/// relative to them, which are taken as exact.
void Optimize(MapGraph& graph,
              const PoseGraphParams& params = {},
              const std::vector<std::int64_t>& held = {});

/// Finds the spots of kind kAmbiguous and kUnclosed again; those of kind kLost stay unchanged.
/// @param view_span  span of an image, map units: shorter open paths are not reported.
void FindWeakSpots(MapGraph& graph, double view_span);

}  // namespace ceilmap::graph
