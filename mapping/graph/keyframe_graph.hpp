#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "mapping/graph/keyframe.hpp"

namespace ceilmap::graph {

/// Keyframes, their estimated poses, and the measured motions between them, arranged for the
/// queries of loop closing: which keyframes are near, and how certain is the motion between two of
/// them? Ids are those of the keyframes; they may have gaps. Not thread-safe.
class KeyframeGraph {
 public:
  /// @param cell  side of the grid cells for position queries, map units, > 0: about an image's
  /// span.
  /// @param arm  lever arm that converts a rotation error to a displacement when the length of a
  /// path is computed, map units, > 0: about half of an image's span.
  KeyframeGraph(double cell, double arm);

  /// @throws std::invalid_argument when the id is negative or known.
  void Add(std::int64_t id, const Pose2& T_map_base);
  /// @throws std::invalid_argument when an end is unknown.
  void Add(const Edge& edge);
  void Move(std::int64_t id, const Pose2& T_map_base);

  [[nodiscard]] bool Has(std::int64_t id) const;
  [[nodiscard]] const Pose2& T_map_base(std::int64_t id) const { return At(id).T_map_base; }
  [[nodiscard]] const std::vector<Edge>& Edges() const { return edges_; }
  /// Indices into Edges().
  [[nodiscard]] const std::vector<std::size_t>& EdgesOf(std::int64_t id) const {
    return At(id).edges;
  }
  /// Poses by id, for OptimizePoses; where no keyframe has the id, the pose has no meaning.
  [[nodiscard]] std::vector<Pose2> Poses() const;

  /// Keyframes whose base lies within `radius` of a point of the map, in order of their ids.
  [[nodiscard]] std::vector<std::int64_t> Near(const Eigen::Vector2d& p_map, double radius) const;

  /// Motion between two keyframes from the edges along the best path.
  struct Relative {
    Pose2 T_from_to;
    /// Covariance of (x, y, yaw) in `from`, with edges taken as independent: an upper bound, since
    /// other paths would add information.
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  };
  /// Motions from `from` to those of `targets` that are connected with it. Dijkstra's search by the
  /// edges' variances. The search ends when all targets are found, so that near targets cost little
  /// in a map of any size.
  [[nodiscard]] std::unordered_map<std::int64_t, Relative> RelativeTo(
      std::int64_t from, std::span<const std::int64_t> targets) const;

 private:
  struct Node {
    bool known = false;
    Pose2 T_map_base;
    std::vector<std::size_t> edges;
  };
  /// A keyframe reached by the search, and the edge through which it was reached.
  struct Reached {
    double variance = 0;
    std::int64_t before = -1;
    std::size_t edge = 0;
    bool settled = false;
  };
  [[nodiscard]] const Node& At(std::int64_t id) const;
  [[nodiscard]] std::int64_t CellOf(const Eigen::Vector2d& p_map) const;
  [[nodiscard]] Relative Along(const std::unordered_map<std::int64_t, Reached>& reached,
                               std::int64_t to) const;

  double cell_;
  double arm_;
  std::vector<Node> nodes_;  // by id
  std::vector<Edge> edges_;
  std::vector<double> variances_;  // of the edges
  std::unordered_map<std::int64_t, std::vector<std::int64_t>> cells_;
};

/// The inverse edge: T_to_from, its information expressed in `to`.
Edge Reversed(const Edge& edge);

}  // namespace ceilmap::graph
