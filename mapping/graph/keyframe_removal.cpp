#include "mapping/graph/keyframe_removal.hpp"

#include <Eigen/LU>
#include <utility>

#include "calib/base/pose_with_covariance.hpp"
#include "mapping/graph/keyframe_graph.hpp"

namespace ceilmap::graph {
namespace {

bool IsPath(const Edge& edge) {
  return edge.kind != Edge::Kind::kLoopClosure;
}

/// The edge from or to the keyframe, so that it begins there.
Edge From(std::int64_t id, const Edge& edge) {
  return edge.from == id ? edge : Reversed(edge);
}

PoseWithCovariance MotionOf(const Edge& edge) {
  return {edge.T_from_to, edge.information.inverse()};
}

void SetMotion(const PoseWithCovariance& motion, Edge& edge) {
  edge.T_from_to = motion.pose;
  const Eigen::Matrix3d information = motion.covariance.inverse();
  edge.information = 0.5 * (information + information.transpose());
}

Edge::Kind KindOf(const Edge& a, const Edge& b) {
  for (const auto kind : {Edge::Kind::kWheels, Edge::Kind::kLoopClosure}) {
    if (a.kind == kind || b.kind == kind) return kind;
  }
  return Edge::Kind::kOdometry;
}

/// The motion along two edges, the second of which begins where the first ends.
Edge Composed(const Edge& first, const Edge& second) {
  Edge edge;
  edge.from = first.from;
  edge.to = second.to;
  edge.kind = KindOf(first, second);
  SetMotion({first.T_from_to * second.T_from_to,
             ComposeCovariance(first.T_from_to,
                               first.information.inverse(),
                               second.T_from_to,
                               second.information.inverse())},
            edge);
  return edge;
}

/// Whether an edge is a better way to a keyframe's neighbour than another one.
bool IsBetter(const Edge& edge, const Edge& than) {
  if (IsPath(edge) != IsPath(than)) return IsPath(edge);
  return edge.information.determinant() > than.information.determinant();
}

}  // namespace

EdgeReduction::EdgeReduction(const std::vector<Edge>& edges,
                             std::unordered_map<std::int64_t, Pose2> poses)
    : poses_(std::move(poses)) {
  edges_.reserve(edges.size());
  for (const Edge& edge : edges) {
    of_keyframe_[edge.from].push_back(edges_.size());
    of_keyframe_[edge.to].push_back(edges_.size());
    edges_.emplace_back(edge);
  }
}

std::vector<std::size_t> EdgeReduction::EdgesOf(std::int64_t id) const {
  std::vector<std::size_t> edges;
  const auto found = of_keyframe_.find(id);
  if (found == of_keyframe_.end()) return edges;
  for (const std::size_t i : found->second) {
    if (edges_[i]) edges.push_back(i);
  }
  return edges;
}

void EdgeReduction::Add(const Edge& edge) {
  for (const std::size_t i : EdgesOf(edge.from)) {
    Edge& known = *edges_[i];
    if (known.kind != edge.kind || (known.from != edge.to && known.to != edge.to)) continue;
    known = From(edge.from, known);
    SetMotion(Fused(MotionOf(known), MotionOf(edge)), known);
    SetByPoses(known);
    return;
  }
  of_keyframe_[edge.from].push_back(edges_.size());
  of_keyframe_[edge.to].push_back(edges_.size());
  edges_.emplace_back(edge);
  SetByPoses(*edges_.back());
}

void EdgeReduction::SetByPoses(Edge& edge) const {
  const auto from = poses_.find(edge.from);
  const auto to = poses_.find(edge.to);
  if (from == poses_.end() || to == poses_.end()) return;
  edge.T_from_to = from->second.Inverse() * to->second;
}

std::optional<std::int64_t> EdgeReduction::Remove(std::int64_t id) {
  std::vector<Edge> own;
  for (const std::size_t i : EdgesOf(id)) {
    own.push_back(From(id, *edges_[i]));
    edges_[i].reset();
  }
  of_keyframe_.erase(id);
  if (own.empty()) return std::nullopt;
  const Edge* best = &own.front();
  for (const Edge& edge : own) {
    if (IsBetter(edge, *best)) best = &edge;
  }
  const Edge from_heir = Reversed(*best);
  for (const Edge& edge : own) {
    if (edge.to != from_heir.from) Add(Composed(from_heir, edge));
  }
  return from_heir.from;
}

std::vector<Edge> EdgeReduction::Edges() const {
  std::vector<Edge> edges;
  for (const std::optional<Edge>& edge : edges_) {
    if (edge) edges.push_back(*edge);
  }
  return edges;
}

}  // namespace ceilmap::graph
