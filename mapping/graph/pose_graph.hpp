#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "calib/base/pose2.hpp"
#include "mapping/graph/keyframe.hpp"

/// The pose graph over SE(2): keyframes whose poses T_map_base are unknown, and edges, the motions
/// measured between them. A keyframe's id is its index in `poses`.
///
/// Fixed are the keyframes in `fixed` and, in every connected part of the graph without such a
/// keyframe, the one with the lowest id: the edges do not determine the position of such a part as
/// a whole.
///
/// All functions @throw InputError for an id out of range, an edge from a keyframe to itself,
/// numbers that are not finite, and an information matrix that is not symmetric and positive
/// definite.
namespace ceilmap::graph {

struct PoseGraphParams {
  /// Scale of the robust loss of loop closures, in sigmas of the whitened residual; 0: plain
  /// squares. The loss is dynamic covariance scaling: an edge counts in full up to the scale and
  /// has almost no influence far beyond it. Unlike Cauchy's loss it is not biased by false
  /// closures, and unlike Geman-McClure's it keeps the full information of the true ones and
  /// converges in fewer steps. Where it disables edges, a second start from the optimum of Cauchy's
  /// loss is made, and the solution of lower cost is used.
  double loop_loss_scale = 3;
  /// The same for odometry edges.
  double odometry_loss_scale = 0;
  int max_iterations = 50;  ///< from each start, at least 1
  /// Stop when the relative decrease of the cost is less than this; > 0.
  double function_tolerance = 1e-8;
  int threads = 0;  ///< 0: all cores

  /// @throws InputError that names field, value and range.
  void Validate() const;
};

struct PoseGraphSummary {
  /// False: max_iterations reached, or no step that lowers the cost was found.
  bool converged = false;
  int iterations = 0;
  /// Half the sum of the robustified squared residuals, before and after the optimization.
  double initial_cost = 0;
  double final_cost = 0;
};

/// Residual of an edge in its from-frame, not whitened:
/// (R_from' (p_to - p_from) - p_edge, wrap(yaw_to - yaw_from - yaw_edge)).
Eigen::Vector3d EdgeResidual(const Edge& edge, const Pose2& T_map_from, const Pose2& T_map_to);

/// r' Omega r of the edge: chi-squared with three degrees of freedom when edge and poses are right.
double EdgeChi2(const Edge& edge, const Pose2& T_map_from, const Pose2& T_map_to);

/// Moves the poses to the optimum. Only keyframes of the given edges are read and moved: the cost
/// depends on these edges alone, so that a small window of a large map can be optimized with the
/// keyframes around it in `fixed`. Yaws are returned in (-pi, pi].
PoseGraphSummary OptimizePoses(std::span<const Edge> edges,
                               std::span<const std::int64_t> fixed,
                               std::vector<Pose2>& poses,
                               const PoseGraphParams& params = {});

/// Marginal covariance of each keyframe's (x, y, yaw) in map axes (as FramePose::covariance),
/// linearized at the poses, with the keyframes in `fixed` taken as exact: zero for these; infinity
/// on the diagonal for keyframes that no path of edges connects with one of them.
///
/// Edges are weighted by the robust loss of `params`.
std::vector<Eigen::Matrix3d> MarginalCovariances(std::span<const Edge> edges,
                                                 std::span<const std::int64_t> fixed,
                                                 const std::vector<Pose2>& poses,
                                                 const PoseGraphParams& params = {});

/// The same, but relative to the map as a whole instead of one keyframe: the error of each keyframe
/// after the map is aligned with the true one by the planar motion of least squared error of the
/// keyframes' positions. It measures the deformation of the map, independently of the error of its
/// origin. In map axes; infinity on the diagonal for keyframes that no path of edges connects with
/// `anchor`.
///
/// With d_i the error of keyframe i for an exact anchor, the fitted motion is g = sum G_i d_i, and
/// the remaining error is d_i - K_i g; its covariance needs three solutions of the normal equations
/// in addition to the marginals.
/// @param anchor  any keyframe of the queried part; the result does not depend on it.
std::vector<Eigen::Matrix3d> GaugeFreeCovariances(std::span<const Edge> edges,
                                                  std::int64_t anchor,
                                                  const std::vector<Pose2>& poses,
                                                  const PoseGraphParams& params = {});

}  // namespace ceilmap::graph
