#include <limits>

#include "mapping/pose_graph.hpp"
#include "mapping/pose_graph_terms.hpp"
#include "mapping/selected_inverse.hpp"

namespace ceilmap::mapping {
namespace {

/// J' J of the edges over the keyframes that are unknown but joined to a fixed one.
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

  /// Of the node, nothing when it is not among the unknown.
  [[nodiscard]] int Row(int node) const { return row_[node]; }
  [[nodiscard]] std::vector<Eigen::Matrix3d> Covariances() const {
    return InverseDiagonal(size_, blocks_);
  }

  static constexpr int kNone = -1;

 private:
  void AddBlock(int row, int column, const Eigen::Matrix3d& value) {
    if (row != kNone && column != kNone) blocks_.push_back({row, column, value});
  }

  std::vector<int> row_;
  int size_ = 0;
  std::vector<MatrixBlock> blocks_;
};

}  // namespace

std::vector<Eigen::Matrix3d> MarginalCovariances(std::span<const Edge> edges,
                                                 std::span<const std::int64_t> fixed,
                                                 const std::vector<Pose2>& poses,
                                                 const PoseGraphParams& params) {
  params.Validate();
  const graph::LocalGraph graph(edges, fixed, poses);
  Information information(graph);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Edge& edge = edges[i];
    const graph::EdgeTerm term =
        graph::Linearize(edge.T_from_to, graph::Whitening(edge), poses[edge.from], poses[edge.to]);
    const double weight =
        graph::LossWeight(term.residual.squaredNorm(), graph::LossScale(edge, params));
    information.Add(graph.From(i), graph.To(i), term, weight);
  }
  const std::vector<Eigen::Matrix3d> solved = information.Covariances();
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  std::vector<Eigen::Matrix3d> covariances(
      poses.size(), Eigen::Vector3d::Constant(kUnknown).asDiagonal().toDenseMatrix());
  for (int node = 0; node < graph.Size(); ++node) {
    if (information.Row(node) != Information::kNone) {
      covariances[graph.Id(node)] = solved[information.Row(node)];
    }
  }
  for (const std::int64_t id : fixed) covariances[id].setZero();
  return covariances;
}

}  // namespace ceilmap::mapping
