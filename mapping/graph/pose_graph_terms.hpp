#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/graph/pose_graph.hpp"

/// Parts shared by the solver for the poses and the one for their covariances. Internal.
namespace ceilmap::graph {

/// The keyframes that edges touch, numbered 0, 1, 2, ... by increasing id: the cost of an operation
/// depends on the size of this graph, not on that of the map.
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
  /// Number of the first node of the connected part that contains the node.
  [[nodiscard]] int Part(int node) const { return part_[node]; }
  [[nodiscard]] bool PartIsFixed(int node) const { return part_fixed_[part_[node]]; }
  /// Whether the node is held fixed: it is in `fixed`, or it is the first of a part without a fixed
  /// node.
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

/// A whitened residual and its derivatives with respect to (x, y, yaw) of the two poses.
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

/// The robust loss of an edge as a function of its chi-squared: dynamic covariance scaling (Agarwal
/// et al. 2013) with Phi = scale^2. Equal to chi-squared up to Phi, and approaches 3 Phi for large
/// values.
double Loss(double chi2, double scale);
/// Its derivative: the fraction of its information with which the edge counts. 1 for scale 0.
double LossWeight(double chi2, double scale);

}  // namespace ceilmap::graph
