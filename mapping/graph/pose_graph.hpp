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
/// What is held: the keyframes in `fixed`, and of every connected part of the graph that has none
/// of them the lowest id; the edges say nothing about where such a part lies as a whole.
///
/// All functions @throw InputError for an id out of range, an edge from a keyframe to
/// itself, numbers that are not finite, and an information matrix that is not symmetric and
/// positive definite.
namespace ceilmap::graph {

struct PoseGraphParams {
  /// Robust loss of loop closures, in sigmas of the whitened residual; 0: plain squares. Dynamic
  /// covariance scaling: up to the scale an edge counts in full, far beyond it not at all. With 5
  /// to 30 % false closures it ends where the true ones alone would; Cauchy's loss is pulled off,
  /// and Geman-McClure's takes two to four times the steps and wastes a part of what is measured.
  /// Where it sets edges aside it also starts from Cauchy's optimum, and the lower cost decides.
  double loop_loss_scale = 3;
  /// The same for odometry.
  double odometry_loss_scale = 0;
  int max_iterations = 50;           ///< from each start, at least 1
  double function_tolerance = 1e-8;  ///< stop when the cost falls by less than this part; > 0
  int threads = 0;                   ///< 0: all cores

  /// @throws InputError that names field, value and range.
  void Validate() const;
};

struct PoseGraphSummary {
  bool converged = false;  ///< false: max_iterations reached, or no step found that helps
  int iterations = 0;
  /// Half the sum of the robustified squared residuals, before and after.
  double initial_cost = 0;
  double final_cost = 0;
};

/// Residual of an edge in its from-frame, not whitened:
/// (R_from' (p_to - p_from) - p_edge, wrap(yaw_to - yaw_from - yaw_edge)).
Eigen::Vector3d EdgeResidual(const Edge& edge, const Pose2& T_map_from, const Pose2& T_map_to);

/// r' Omega r of the edge: chi-squared with three degrees of freedom when edge and poses are right.
double EdgeChi2(const Edge& edge, const Pose2& T_map_from, const Pose2& T_map_to);

/// Moves the poses to the optimum. Only keyframes that an edge touches are read and moved: the cost
/// is that of the edges given, so that a small window of a large map can be solved with the
/// keyframes around it in `fixed`. Yaws come out in (-pi, pi].
PoseGraphSummary OptimizePoses(std::span<const Edge> edges,
                               std::span<const std::int64_t> fixed,
                               std::vector<Pose2>& poses,
                               const PoseGraphParams& params = {});

/// Marginal covariance of each keyframe's (x, y, yaw) in map axes (as FramePose::covariance),
/// linearized at the poses, given that the keyframes in `fixed` are right: zero for these; infinity
/// on the diagonal for keyframes that no path of edges joins to one of them.
///
/// Edges count with the weight that the robust loss of `params` leaves them.
std::vector<Eigen::Matrix3d> MarginalCovariances(std::span<const Edge> edges,
                                                 std::span<const std::int64_t> fixed,
                                                 const std::vector<Pose2>& poses,
                                                 const PoseGraphParams& params = {});

/// The same, but relative to the map as a whole instead of one keyframe: how far each keyframe may
/// lie off once the map is laid onto the truth by the planar motion with the least squared error of
/// the keyframes' positions. A map is bent by this much; where it begins does not matter. In map
/// axes; infinity on the diagonal for keyframes that no path of edges joins to `anchor`.
///
/// With d_i the error of keyframe i given that the anchor is right, the fitted motion is
/// g = sum G_i d_i, and what is left is d_i - K_i g; its covariance needs three solutions of the
/// normal equations beyond the marginals.
/// @param anchor  any keyframe of the part that is asked for; the result does not depend on it.
std::vector<Eigen::Matrix3d> GaugeFreeCovariances(std::span<const Edge> edges,
                                                  std::int64_t anchor,
                                                  const std::vector<Pose2>& poses,
                                                  const PoseGraphParams& params = {});

}  // namespace ceilmap::graph
