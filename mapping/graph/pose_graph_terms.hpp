#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/graph/pose_graph.hpp"

/// What solving for the poses and for their covariances have in common. Internal.
namespace ceilmap::graph {

/// The keyframes that edges touch, numbered 0, 1, 2, ... by rising id: what is done with a graph
/// costs by its own size, not by the map's.
class LocalGraph {
 public:
  /// @throws InputError as pose_graph.hpp says.
  LocalGraph(std::span<const Edge> edges,
             std::span<const std::int64_t> fixed,
             std::span<const Pose2> poses);

  [[nodiscard]] int Size() const { return static_cast<int>(ids_.size()); }
  [[nodiscard]] std::int64_t Id(int node) const { return ids_[node]; }
  [[nodiscard]] int From(std::size_t edge) const { return from_[edge]; }
  [[nodiscard]] int To(std::size_t edge) const { return to_[edge]; }
  [[nodiscard]] bool IsFixed(int node) const { return fixed_[node]; }
  /// Number of the first node of the connected part that the node is in.
  [[nodiscard]] int Part(int node) const { return part_[node]; }
  [[nodiscard]] bool PartIsFixed(int node) const { return part_fixed_[part_[node]]; }
  /// Held where it is: fixed, or the first of a part with nothing fixed.
  [[nodiscard]] bool IsHeld(int node) const {
    return fixed_[node] || (part_[node] == node && !part_fixed_[node]);
  }

 private:
  int Node(std::int64_t id) const;
  void FindParts();

  std::vector<std::int64_t> ids_;
  std::vector<int> from_, to_;
  std::vector<bool> fixed_;
  std::vector<int> part_;
  std::vector<bool> part_fixed_;  // by the part's first node
};

/// Upper triangular W with W' W = information.
/// @throws InputError when the information is not symmetric and positive definite.
Eigen::Matrix3d Whitening(const Edge& edge);

/// A whitened residual and its derivatives by (x, y, yaw) of the two poses.
struct EdgeTerm {
  Eigen::Vector3d residual;
  Eigen::Matrix3d by_from;
  Eigen::Matrix3d by_to;
};
EdgeTerm Linearize(const Pose2& T_from_to,
                   const Eigen::Matrix3d& whitening,
                   const Pose2& T_map_from,
                   const Pose2& T_map_to);

/// The scale of the edge's robust loss; 0: plain squares.
double LossScale(const Edge& edge, const PoseGraphParams& params);

/// The robust loss of an edge, as a function of its chi-squared: dynamic covariance scaling
/// (Agarwal et al. 2013) with Phi = scale^2. Plain up to Phi, 3 Phi from far away.
double Loss(double chi2, double scale);
/// Its derivative, the part of its information that the edge keeps. 1 for scale 0.
double LossWeight(double chi2, double scale);

}  // namespace ceilmap::graph
