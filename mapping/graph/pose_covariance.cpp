#include <limits>

#include "calib/base/error.hpp"
#include "calib/base/sparse_cholesky.hpp"
#include "mapping/graph/pose_graph.hpp"
#include "mapping/graph/pose_graph_terms.hpp"
#include "mapping/graph/selected_inverse.hpp"

namespace ceilmap::graph {
namespace {

/// J' J of the edges over the unknown keyframes that are connected with a fixed one.
class Information {
 public:
  explicit Information(const graph::LocalGraph& graph) : row_(graph.Size(), kNone) {
    for (int node = 0; node < graph.Size(); ++node) {
      if (graph.PartIsFixed(node) && !graph.IsFixed(node)) row_[node] = size_++;
    }
  }

  void Add(int from, int to, const graph::EdgeTerm& term, double weight) {
    AddBlock(row_[from], row_[from], weight * term.by_from.transpose() * term.by_from);
    AddBlock(row_[to], row_[to], weight * term.by_to.transpose() * term.by_to);
    if (row_[from] >= row_[to]) {
      AddBlock(row_[from], row_[to], weight * term.by_from.transpose() * term.by_to);
    } else {
      AddBlock(row_[to], row_[from], weight * term.by_to.transpose() * term.by_from);
    }
  }

  /// Row of the node; kNone when it is not among the unknowns.
  [[nodiscard]] int Row(int node) const { return row_[node]; }
  [[nodiscard]] std::vector<Eigen::Matrix3d> Covariances() const {
    return InverseDiagonal(size_, blocks_);
  }

  /// X with (J' J) X = b; both have three rows for each unknown keyframe.
  [[nodiscard]] Eigen::MatrixX3d Solve(const Eigen::MatrixX3d& b) const;
  [[nodiscard]] int Size() const { return size_; }

  static constexpr int kNone = -1;

 private:
  void AddBlock(int row, int column, const Eigen::Matrix3d& value) {
    if (row != kNone && column != kNone) blocks_.push_back({row, column, value});
  }

  std::vector<int> row_;
  int size_ = 0;
  std::vector<MatrixBlock> blocks_;
};

Eigen::MatrixX3d Information::Solve(const Eigen::MatrixX3d& b) const {
  std::vector<SparseCholesky::Entry> entries;
  entries.reserve(9 * blocks_.size());
  for (const MatrixBlock& block : blocks_) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        entries.push_back({3 * block.row + i, 3 * block.column + j, block.value(i, j)});
      }
    }
  }
  const SparseCholesky solver(3 * size_, entries);
  if (!solver.HasFactors()) {
    throw RunError("the pose graph's covariance cannot be computed: it is not determined");
  }
  return solver.Solve(b);
}

/// The edges linearized at the poses, weighted by the robust loss.
Information Gather(std::span<const Edge> edges,
                   const graph::LocalGraph& graph,
                   const std::vector<Pose2>& poses,
                   const PoseGraphParams& params) {
  Information information(graph);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Edge& edge = edges[i];
    const graph::EdgeTerm term =
        graph::Linearize(edge.T_from_to, graph::Whitening(edge), poses[edge.from], poses[edge.to]);
    const double weight =
        graph::LossWeight(term.residual.squaredNorm(), graph::LossScale(edge, params));
    information.Add(graph.From(i), graph.To(i), term, weight);
  }
  return information;
}

std::vector<Eigen::Matrix3d> AllUnknown(std::size_t count) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  return {count, Eigen::Vector3d::Constant(kUnknown).asDiagonal().toDenseMatrix()};
}

}  // namespace

std::vector<Eigen::Matrix3d> MarginalCovariances(std::span<const Edge> edges,
                                                 std::span<const std::int64_t> fixed,
                                                 const std::vector<Pose2>& poses,
                                                 const PoseGraphParams& params) {
  params.Validate();
  const graph::LocalGraph graph(edges, fixed, poses);
  const Information information = Gather(edges, graph, poses, params);
  const std::vector<Eigen::Matrix3d> solved = information.Covariances();
  std::vector<Eigen::Matrix3d> covariances = AllUnknown(poses.size());
  for (int node = 0; node < graph.Size(); ++node) {
    if (information.Row(node) != Information::kNone) {
      covariances[graph.Id(node)] = solved[information.Row(node)];
    }
  }
  for (const std::int64_t id : fixed) covariances[id].setZero();
  return covariances;
}

std::vector<Eigen::Matrix3d> GaugeFreeCovariances(std::span<const Edge> edges,
                                                  std::int64_t anchor,
                                                  const std::vector<Pose2>& poses,
                                                  const PoseGraphParams& params) {
  params.Validate();
  const std::vector<std::int64_t> fixed = {anchor};
  const graph::LocalGraph graph(edges, fixed, poses);
  const Information information = Gather(edges, graph, poses, params);
  std::vector<int> part;
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (int node = 0; node < graph.Size(); ++node) {
    if (!graph.PartIsFixed(node)) continue;
    part.push_back(node);
    centroid += poses[graph.Id(node)].Translation();
  }
  std::vector<Eigen::Matrix3d> covariances = AllUnknown(poses.size());
  if (part.size() < 2) {
    covariances[anchor].setZero();
    return covariances;
  }
  centroid /= static_cast<double>(part.size());
  const auto arm = [&](int node) -> Eigen::Vector2d {
    return poses[graph.Id(node)].Translation() - centroid;
  };
  double inertia = 0;
  for (const int node : part) inertia += arm(node).squaredNorm();
  const auto n = static_cast<double>(part.size());
  // G', one block for each unknown keyframe: the derivative of the fitted motion with respect to
  // the keyframe's error.
  Eigen::MatrixX3d G = Eigen::MatrixX3d::Zero(3 * information.Size(), 3);
  for (const int node : part) {
    const int row = information.Row(node);
    if (row == Information::kNone) continue;
    const Eigen::Vector2d a = arm(node);
    G.block<2, 3>(3 * row, 0) << 1 / n, 0, -a.y() / inertia, 0, 1 / n, a.x() / inertia;
  }
  const Eigen::MatrixX3d PG = information.Solve(G);
  const Eigen::Matrix3d of_motion = G.transpose() * PG;
  const std::vector<Eigen::Matrix3d> solved = information.Covariances();
  for (const int node : part) {
    const Eigen::Vector2d a = arm(node);
    Eigen::Matrix3d K;
    K << 1, 0, -a.y(), 0, 1, a.x(), 0, 0, 1;
    Eigen::Matrix3d& covariance = covariances[graph.Id(node)];
    covariance = K * of_motion * K.transpose();
    const int row = information.Row(node);
    if (row == Information::kNone) continue;
    const Eigen::Matrix3d mixed = PG.block<3, 3>(3 * row, 0) * K.transpose();
    covariance += solved[row] - mixed - mixed.transpose();
  }
  return covariances;
}

}  // namespace ceilmap::graph
