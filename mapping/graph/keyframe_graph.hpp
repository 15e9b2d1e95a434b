#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "mapping/graph/keyframe.hpp"

namespace ceilmap::graph {

/// Keyframes, where they are thought to be, and the measured motions between them, arranged for the
/// questions that loop closing asks: who is near, and how well is the motion between two of them
/// known already? Ids are those of the keyframes; they may have gaps. Not thread-safe.
class KeyframeGraph {
 public:
  /// @param cell  side of the cells in which positions are looked up, map units, > 0: about what a
  ///   image spans.
  /// @param arm  a rotation's error counts in the length of a path by what it moves at this
  ///   distance, map units, > 0: about half of what an image spans.
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
  /// Poses by id, for OptimizePoses; where no keyframe has the id, the pose means nothing.
  [[nodiscard]] std::vector<Pose2> Poses() const;

  /// Keyframes whose base lies within `radius` of a point of the map, in order of their ids.
  [[nodiscard]] std::vector<std::int64_t> Near(const Eigen::Vector2d& p_map, double radius) const;

  /// What the edges along the best path say of the motion between two keyframes.
  struct Relative {
    Pose2 T_from_to;
    /// Of (x, y, yaw) in `from`, edges taken as independent: an upper bound, since other paths
    /// would add to what is known.
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  };
  /// Motions from `from` to those of `targets` that a path leads to. Dijkstra's search by the
  /// edges' variances; ends when all targets are found, so that neighbours cost little in a map of
  /// any size.
  [[nodiscard]] std::unordered_map<std::int64_t, Relative> RelativeTo(
      std::int64_t from, std::span<const std::int64_t> targets) const;

 private:
  struct Node {
    bool known = false;
    Pose2 T_map_base;
    std::vector<std::size_t> edges;
  };
  /// Keyframe reached by the search, and through which edge.
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

/// The same edge measured the other way round: T_to_from, its information expressed in `to`.
Edge Reversed(const Edge& edge);

}  // namespace ceilmap::graph
