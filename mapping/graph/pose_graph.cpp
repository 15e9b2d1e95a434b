#include "mapping/graph/pose_graph.hpp"

#include <ceres/ceres.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <thread>

#include "calib/base/field_check.hpp"
#include "mapping/graph/pose_graph_terms.hpp"

namespace ceilmap::graph {
namespace {

using Block = std::array<double, 3>;  // x, y, yaw

Pose2 ToPose(const double* p) {
  return {p[0], p[1], p[2]};
}

/// Yaw needs no manifold: the residual wraps the difference, so that yaws that differ by whole
/// turns are equivalent.
class EdgeCost final : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  EdgeCost(const Pose2& T_from_to, const Eigen::Matrix3d& whitening)
      : T_from_to_(T_from_to), whitening_(whitening) {}

  bool Evaluate(double const* const* poses, double* residual, double** jacobians) const override {
    using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const graph::EdgeTerm term =
        graph::Linearize(T_from_to_, whitening_, ToPose(poses[0]), ToPose(poses[1]));
    Eigen::Map<Eigen::Vector3d>{residual} = term.residual;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) Eigen::Map<Matrix>{jacobians[0]} = term.by_from;
    if (jacobians[1] != nullptr) Eigen::Map<Matrix>{jacobians[1]} = term.by_to;
    return true;
  }

 private:
  Pose2 T_from_to_;
  Eigen::Matrix3d whitening_;
};

/// graph::Loss in the form that Ceres requires.
class ScalingLoss final : public ceres::LossFunction {
 public:
  explicit ScalingLoss(double scale) : scale_(scale) {}

  void Evaluate(double chi2, double rho[3]) const override {
    const double phi = scale_ * scale_;
    rho[0] = graph::Loss(chi2, scale_);
    rho[1] = graph::LossWeight(chi2, scale_);
    rho[2] = chi2 <= phi ? 0 : -2 * rho[1] / (phi + chi2);
  }

 private:
  double scale_;
};

ceres::Problem::Options ProblemOptions() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;  // LocalGraph has checked
  return options;
}

ceres::Solver::Options SolverOptions(const PoseGraphParams& params) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = params.max_iterations;
  options.function_tolerance = params.function_tolerance;
  // Relative to the map's size: the default would be micrometres
  options.parameter_tolerance = 1e-12;
  // Gauss-Newton until a step fails: even weak damping slows the correction of drift in long chains
  // and needs three times as many steps.
  options.initial_trust_region_radius = options.max_trust_region_radius;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  options.num_threads = params.threads > 0 ? params.threads : cores;
  return options;
}

class Solver {
 public:
  Solver(std::span<const Edge> edges,
         const graph::LocalGraph& graph,
         const std::vector<Pose2>& poses,
         const PoseGraphParams& params)
      : options_(SolverOptions(params)), params_(params), problem_(ProblemOptions()) {
    blocks_.resize(graph.Size());
    for (int node = 0; node < graph.Size(); ++node) {
      const Pose2& pose = poses[graph.Id(node)];
      blocks_[node] = {pose.x, pose.y, pose.yaw};
      problem_.AddParameterBlock(blocks_[node].data(), 3);
      if (graph.IsHeld(node)) problem_.SetParameterBlockConstant(blocks_[node].data());
    }
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const bool is_loop = edges[i].kind == Edge::Kind::kLoopClosure;
      ceres::LossFunction* loss = is_loop ? &loop_loss_ : &odometry_loss_;
      if (graph::LossScale(edges[i], params) == 0) loss = nullptr;
      costs_.emplace_back(edges[i].T_from_to, graph::Whitening(edges[i]));
      problem_.AddResidualBlock(
          &costs_.back(), loss, blocks_[graph.From(i)].data(), blocks_[graph.To(i)].data());
    }
  }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  [[nodiscard]] const std::vector<Block>& Blocks() const { return blocks_; }
  /// The blocks keep their addresses in memory: Ceres identifies them by address.
  void SetBlocks(const std::vector<Block>& blocks) {
    std::copy(blocks.begin(), blocks.end(), blocks_.begin());
  }

  /// Moves the blocks from their current values to the nearest optimum under this loss.
  template <typename Loss>
  PoseGraphSummary Run() {
    loop_loss_.Reset(new Loss(params_.loop_loss_scale), ceres::TAKE_OWNERSHIP);
    odometry_loss_.Reset(new Loss(params_.odometry_loss_scale), ceres::TAKE_OWNERSHIP);
    ceres::Solver::Summary solved;
    ceres::Solve(options_, &problem_, &solved);
    PoseGraphSummary summary;
    summary.converged = solved.termination_type == ceres::CONVERGENCE;
    summary.iterations = std::max(0, static_cast<int>(solved.iterations.size()) - 1);
    summary.initial_cost = solved.initial_cost;
    summary.final_cost = solved.final_cost;
    return summary;
  }

 private:
  ceres::Solver::Options options_;
  PoseGraphParams params_;
  std::vector<Block> blocks_;
  std::deque<EdgeCost> costs_;  // with stable addresses
  ceres::LossFunctionWrapper loop_loss_{nullptr, ceres::TAKE_OWNERSHIP};
  ceres::LossFunctionWrapper odometry_loss_{nullptr, ceres::TAKE_OWNERSHIP};
  ceres::Problem problem_;
};

Pose2 WrappedPose(const Block& block) {
  return {block[0], block[1], WrapAngle(block[2])};
}

/// Whether the loss gives some edge a weight that an edge with correct covariance would practically
/// never get.
bool SetsEdgesAside(std::span<const Edge> edges,
                    const graph::LocalGraph& graph,
                    const std::vector<Block>& blocks,
                    const PoseGraphParams& params) {
  constexpr double kNever = 0.1;  // weight; at scale 3, chi-squared of 48
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const double scale = graph::LossScale(edges[i], params);
    if (scale == 0) continue;
    const double chi2 =
        EdgeChi2(edges[i], WrappedPose(blocks[graph.From(i)]), WrappedPose(blocks[graph.To(i)]));
    if (graph::LossWeight(chi2, scale) < kNever) return true;
  }
  return false;
}

}  // namespace

void PoseGraphParams::Validate() const {
  const FieldCheck require("pose graph");
  require(std::isfinite(loop_loss_scale) && loop_loss_scale >= 0,
          "loop_loss_scale",
          loop_loss_scale,
          "at least 0");
  require(std::isfinite(odometry_loss_scale) && odometry_loss_scale >= 0,
          "odometry_loss_scale",
          odometry_loss_scale,
          "at least 0");
  require(max_iterations >= 1, "max_iterations", max_iterations, "at least 1");
  require(function_tolerance > 0 && function_tolerance < 1,
          "function_tolerance",
          function_tolerance,
          "in (0, 1)");
  require(threads >= 0, "threads", threads, "at least 0");
}

Eigen::Vector3d EdgeResidual(const Edge& edge, const Pose2& T_map_from, const Pose2& T_map_to) {
  const Eigen::Matrix3d unweighted = Eigen::Matrix3d::Identity();
  return graph::Linearize(edge.T_from_to, unweighted, T_map_from, T_map_to).residual;
}

double EdgeChi2(const Edge& edge, const Pose2& T_map_from, const Pose2& T_map_to) {
  const Eigen::Vector3d residual = EdgeResidual(edge, T_map_from, T_map_to);
  return residual.dot(edge.information * residual);
}

PoseGraphSummary OptimizePoses(std::span<const Edge> edges,
                               std::span<const std::int64_t> fixed,
                               std::vector<Pose2>& poses,
                               const PoseGraphParams& params) {
  params.Validate();
  const graph::LocalGraph graph(edges, fixed, poses);
  Solver solver(edges, graph, poses, params);
  const std::vector<Block> start = solver.Blocks();
  PoseGraphSummary summary = solver.Run<ScalingLoss>();
  if (SetsEdgesAside(edges, graph, solver.Blocks(), params)) {
    // Far from the optimum, a true closure of a long loop that has drifted has no more influence
    // than a false one. Cauchy's loss never disables an edge: it brings the loop close enough for
    // the decision.
    const std::vector<Block> near = solver.Blocks();
    solver.SetBlocks(start);
    const PoseGraphSummary pulled = solver.Run<ceres::CauchyLoss>();
    const PoseGraphSummary far = solver.Run<ScalingLoss>();
    summary.iterations += pulled.iterations + far.iterations;
    if (far.final_cost < summary.final_cost) {
      summary.final_cost = far.final_cost;
      summary.converged = far.converged;
    } else {
      solver.SetBlocks(near);
    }
  }
  for (int node = 0; node < graph.Size(); ++node) {
    if (!graph.IsHeld(node)) poses[graph.Id(node)] = WrappedPose(solver.Blocks()[node]);
  }
  return summary;
}

}  // namespace ceilmap::graph
