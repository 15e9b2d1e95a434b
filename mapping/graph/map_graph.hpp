#pragma once

#include <cstdint>
#include <string>
#include <unordered_set>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/pose_graph.hpp"

/// A map without its images: what is known of poses, by what measurements, and how well.
namespace ceilmap::graph {

/// What became of the places where a loop might have closed.
struct LoopCounts {
  std::int64_t compared = 0;        ///< pairs of keyframes that were registered
  std::int64_t accepted = 0;        ///< became edges of the graph
  std::int64_t no_match = 0;        ///< the images do not agree, or show nothing
  std::int64_t ambiguous = 0;       ///< several motions fit (periodic ceiling): left out
  std::int64_t off_prediction = 0;  ///< agree, but on a motion that the rest of the map excludes
  std::int64_t unconfirmed = 0;     ///< agree, but far from certain beforehand and said by one pair
  std::int64_t outliers = 0;        ///< of the accepted: taken out again by the pose graph

  LoopCounts& operator+=(const LoopCounts& other);
};

/// How well the measurements of a map agree with each other.
struct MapQuality {
  LoopCounts loops;
  /// Mean squared residual of the edges in units of what they claim, per degree of freedom of the
  /// graph: 1 where the covariances of the measurements are right.
  double chi2_per_dof = 0;
  double max_edge_sigmas = 0;  ///< largest residual of an edge that was kept
  double odometry_rms = 0;  ///< residuals of translations, root mean square of an axis, map units
  double loop_rms = 0;
};

/// A place where the map deserves less trust.
struct WeakSpot {
  enum class Kind {
    /// Several motions explain what is seen here: the ceiling repeats itself. extent: length of the
    /// way on which it does, map units.
    kAmbiguous,
    kLost,      ///< frames could not be placed here; extent: how many
    kUnclosed,  ///< the path leads on without meeting itself; extent: its length in map units
  };
  Kind kind = Kind::kAmbiguous;
  std::int64_t keyframe_id = -1;  ///< nearest in time, or the middle one
  double x = 0;                   ///< in the map
  double y = 0;
  double extent = 0;
};
const char* ToString(WeakSpot::Kind kind);

struct MapGraph {
  std::vector<Keyframe> keyframes;  ///< without images; ids rise, with gaps or without
  std::vector<Edge> edges;
  std::vector<FramePose> trajectory;  ///< in order of time for each recording
  std::vector<WeakSpot> weak_spots;
  MapQuality quality;
};

/// Poses of the keyframes by id, for OptimizePoses.
std::vector<Pose2> PosesById(const MapGraph& graph);

/// Puts the keyframes where `poses` (by id) says; each frame of the trajectory goes with its
/// keyframe, like a rigid body, and covariances are turned with them.
void MoveKeyframes(MapGraph& graph, const std::vector<Pose2>& poses);

/// Length of the way through the frames, map units; gaps count straight.
double PathLength(const std::vector<FramePose>& trajectory);

/// The keyframes' ids by parts that edges hold together, the largest part first, equals by age.
std::vector<std::vector<std::int64_t>> Components(const MapGraph& graph);

/// Takes out all other keyframes, with their edges, frames and weak spots.
void KeepOnly(MapGraph& graph, const std::unordered_set<std::int64_t>& keyframe_ids);

/// Moves the whole map: T_new_base = T_new_old * T_old_base, covariances with it.
void MoveAll(MapGraph& graph, const Pose2& T_new_old);

struct OptimizeParams {
  PoseGraphParams pose_graph;
  /// A loop closure whose residual is larger, in sigmas, is taken out when the rest of the graph
  /// agrees without it.
  double max_sigmas = 6;
};

/// The most likely poses of all keyframes given all edges; the first keyframe stays. Loop closures
/// that contradict the rest are removed (quality.loops.outliers). Then the covariances of
/// keyframes and frames relative to the first keyframe, scaled up where the residuals are larger
/// than the measurements claim, and the figures of `quality`.
///
/// Every keyframe must be connected with the first by edges.
void Optimize(MapGraph& graph, const OptimizeParams& params = {});

/// Finds the spots of kind kAmbiguous and kUnclosed anew; those of kind kLost stay.
/// @param view_span  what an image spans, map units: shorter open paths are not mentioned.
void FindWeakSpots(MapGraph& graph, double view_span);

}  // namespace ceilmap::graph
