#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "mapping/graph/keyframe.hpp"

namespace ceilmap::graph {

/// The edges of a graph from which keyframes are removed, one after the other, while what they tell
/// of the others is kept. The edges of a removed keyframe lead through its best neighbour, its
/// heir, instead: the motion from the heir to each other neighbour is composed, and its covariance
/// is the sum of both. This is the Chow-Liu tree of the marginal distribution of the neighbours
/// (Kretzschmar & Stachniss, IJRR 2012): k edges become k - 1, a graph stays connected, and without
/// loops nothing is lost. An edge between two keyframes that have one of its kind is fused with it,
/// so that the number of edges is bounded.
///
/// Poses are not touched: they stay at the optimum of all measurements.
class EdgeReduction {
 public:
  /// @param poses  of the keyframes, by id: the optimum of the edges. New edges state the motion
  /// between these poses, because removed measurements had a part in them; the optimum of what
  /// remains is then near it. Between keyframes without a pose it is the one that was measured.
  explicit EdgeReduction(const std::vector<Edge>& edges,
                         std::unordered_map<std::int64_t, Pose2> poses = {});

  /// Removes a keyframe. Where it has edges of odometry or wheels, the heir is one of these
  /// neighbours: along the path the graph stays connected by edges that are no loop closures.
  /// @return the heir; nothing, and nothing is done, when the keyframe has no edges.
  std::optional<std::int64_t> Remove(std::int64_t id);

  /// Those that remain, in the order of the first ones, then the composed ones.
  [[nodiscard]] std::vector<Edge> Edges() const;

 private:
  [[nodiscard]] std::vector<std::size_t> EdgesOf(std::int64_t id) const;
  void Add(const Edge& edge);

  void SetByPoses(Edge& edge) const;

  std::unordered_map<std::int64_t, Pose2> poses_;
  std::vector<std::optional<Edge>> edges_;                                  // none: removed
  std::unordered_map<std::int64_t, std::vector<std::size_t>> of_keyframe_;  // also removed ones
};

}  // namespace ceilmap::graph
