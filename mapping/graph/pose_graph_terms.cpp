#include "mapping/graph/pose_graph_terms.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "calib/base/error.hpp"

namespace ceilmap::graph {
namespace {

bool IsFinite(const Pose2& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.yaw);
}

void CheckId(std::int64_t id, std::span<const Pose2> poses, const char* what) {
  if (id < 0 || id >= static_cast<std::int64_t>(poses.size())) {
    throw InputError(fmt::format("pose graph: {} {}, must be from 0 to {} ({} keyframes)",
                                 what,
                                 id,
                                 static_cast<std::int64_t>(poses.size()) - 1,
                                 poses.size()));
  }
  if (!IsFinite(poses[id])) {
    throw InputError(fmt::format("pose graph: the pose of keyframe {} is not finite", id));
  }
}

void CheckEdge(const Edge& edge, std::span<const Pose2> poses) {
  CheckId(edge.from, poses, "edge from keyframe");
  CheckId(edge.to, poses, "edge to keyframe");
  if (edge.from == edge.to) {
    throw InputError(fmt::format("pose graph: edge from keyframe {} to itself", edge.from));
  }
  if (!IsFinite(edge.T_from_to)) {
    throw InputError(
        fmt::format("pose graph: edge {} -> {}: the motion is not finite", edge.from, edge.to));
  }
}

}  // namespace

LocalGraph::LocalGraph(std::span<const Edge> edges,
                       std::span<const std::int64_t> fixed,
                       std::span<const Pose2> poses) {
  ids_.reserve(2 * edges.size());
  for (const Edge& edge : edges) {
    CheckEdge(edge, poses);
    ids_.push_back(edge.from);
    ids_.push_back(edge.to);
  }
  std::sort(ids_.begin(), ids_.end());
  ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
  for (const Edge& edge : edges) {
    from_.push_back(Node(edge.from));
    to_.push_back(Node(edge.to));
  }
  fixed_.resize(ids_.size());
  for (const std::int64_t id : fixed) {
    CheckId(id, poses, "fixed keyframe");
    const int node = Node(id);
    if (node < Size() && ids_[node] == id) fixed_[node] = true;
  }
  FindParts();
}

int LocalGraph::Node(std::int64_t id) const {
  return static_cast<int>(std::lower_bound(ids_.begin(), ids_.end(), id) - ids_.begin());
}

void LocalGraph::FindParts() {
  part_.resize(ids_.size());
  std::iota(part_.begin(), part_.end(), 0);
  const auto root = [this](int node) {
    while (part_[node] != node) node = part_[node] = part_[part_[node]];
    return node;
  };
  for (std::size_t i = 0; i < from_.size(); ++i) {
    const auto [first, second] = std::minmax({root(from_[i]), root(to_[i])});
    part_[second] = first;  // so that the root of a part is its first node
  }
  part_fixed_.resize(ids_.size());
  for (int node = 0; node < Size(); ++node) {
    part_[node] = root(node);
    if (fixed_[node]) part_fixed_[part_[node]] = true;
  }
}

Eigen::Matrix3d Whitening(const Edge& edge) {
  const Eigen::Matrix3d& information = edge.information;
  const Eigen::LLT<Eigen::Matrix3d> llt(information);
  const bool symmetric =
      information.isApprox(information.transpose(), 1e-9);  // false for values that are not finite
  if (!symmetric || llt.info() != Eigen::Success) {
    throw InputError(
        fmt::format("pose graph: edge {} -> {}: the information is not symmetric and positive "
                    "definite",
                    edge.from,
                    edge.to));
  }
  return llt.matrixU();
}

EdgeTerm Linearize(const Pose2& T_from_to,
                   const Eigen::Matrix3d& whitening,
                   const Pose2& T_map_from,
                   const Pose2& T_map_to) {
  const Eigen::Matrix2d R_from_map = T_map_from.Rotation().transpose();
  const Eigen::Vector2d p_from = R_from_map * (T_map_to.Translation() - T_map_from.Translation());
  EdgeTerm term;
  term.residual << p_from - T_from_to.Translation(),
      WrapAngle(T_map_to.yaw - T_map_from.yaw - T_from_to.yaw);
  term.by_to << R_from_map, Eigen::Vector2d::Zero(), 0, 0, 1;
  term.by_from = -term.by_to;
  term.by_from.topRightCorner<2, 1>() << p_from.y(), -p_from.x();
  term.residual = whitening * term.residual;
  term.by_from = whitening * term.by_from;
  term.by_to = whitening * term.by_to;
  return term;
}

double LossScale(const Edge& edge, const PoseGraphParams& params) {
  return edge.kind == Edge::Kind::kLoopClosure ? params.loop_loss_scale
                                               : params.odometry_loss_scale;
}

double Loss(double chi2, double scale) {
  const double phi = scale * scale;
  if (scale == 0 || chi2 <= phi) return chi2;
  return phi * (3 * chi2 - phi) / (chi2 + phi);
}

double LossWeight(double chi2, double scale) {
  const double phi = scale * scale;
  if (scale == 0 || chi2 <= phi) return 1;
  const double scaling = 2 * phi / (phi + chi2);
  return scaling * scaling;
}

}  // namespace ceilmap::graph
