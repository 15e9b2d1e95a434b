#include "mapping/graph/keyframe_graph.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <queue>
#include <stdexcept>
#include <string>

#include "calib/base/pose_with_covariance.hpp"

namespace ceilmap::graph {
namespace {

std::int64_t CellKey(std::int64_t column, std::int64_t row) {
  return row * (std::int64_t{1} << 32) + column;
}

}  // namespace

Edge Reversed(const Edge& edge) {
  Edge back = edge;
  std::swap(back.from, back.to);
  back.T_from_to = edge.T_from_to.Inverse();
  // T^-1 = (-R^T t, -yaw): its derivative with respect to (t, yaw).
  const Eigen::Matrix2d Rt = edge.T_from_to.Rotation().transpose();
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
  jacobian.topLeftCorner<2, 2>() = -Rt;
  const Eigen::Vector2d t = back.T_from_to.Translation();
  jacobian(0, 2) = t.y();
  jacobian(1, 2) = -t.x();
  jacobian(2, 2) = -1;
  const Eigen::Matrix3d inverse = jacobian.inverse();
  back.information = inverse.transpose() * edge.information * inverse;
  return back;
}

KeyframeGraph::KeyframeGraph(double cell, double arm) : cell_(cell), arm_(arm) {
  if (!(cell > 0) || !(arm > 0)) {
    throw std::invalid_argument("KeyframeGraph: cell and arm must be > 0");
  }
}

std::int64_t KeyframeGraph::CellOf(const Eigen::Vector2d& p_map) const {
  return CellKey(static_cast<std::int64_t>(std::floor(p_map.x() / cell_)),
                 static_cast<std::int64_t>(std::floor(p_map.y() / cell_)));
}

bool KeyframeGraph::Has(std::int64_t id) const {
  return id >= 0 && id < static_cast<std::int64_t>(nodes_.size()) &&
         nodes_[static_cast<std::size_t>(id)].known;
}

const KeyframeGraph::Node& KeyframeGraph::At(std::int64_t id) const {
  if (!Has(id)) throw std::invalid_argument("KeyframeGraph: no keyframe " + std::to_string(id));
  return nodes_[static_cast<std::size_t>(id)];
}

void KeyframeGraph::Add(std::int64_t id, const Pose2& T_map_base) {
  if (id < 0 || Has(id)) {
    throw std::invalid_argument("KeyframeGraph: keyframe " + std::to_string(id) + " again");
  }
  const auto index = static_cast<std::size_t>(id);
  if (index >= nodes_.size()) nodes_.resize(index + 1);
  nodes_[index] = {true, T_map_base, {}};
  cells_[CellOf(T_map_base.Translation())].push_back(id);
}

void KeyframeGraph::Add(const Edge& edge) {
  if (!Has(edge.from) || !Has(edge.to) || edge.from == edge.to) {
    throw std::invalid_argument("KeyframeGraph: an edge needs two known keyframes");
  }
  const Eigen::Matrix3d covariance = edge.information.inverse();
  variances_.push_back(covariance(0, 0) + covariance(1, 1) + arm_ * arm_ * covariance(2, 2));
  nodes_[static_cast<std::size_t>(edge.from)].edges.push_back(edges_.size());
  nodes_[static_cast<std::size_t>(edge.to)].edges.push_back(edges_.size());
  edges_.push_back(edge);
}

void KeyframeGraph::Move(std::int64_t id, const Pose2& T_map_base) {
  const std::int64_t before = CellOf(At(id).T_map_base.Translation());
  const std::int64_t after = CellOf(T_map_base.Translation());
  nodes_[static_cast<std::size_t>(id)].T_map_base = T_map_base;
  if (before == after) return;
  std::erase(cells_[before], id);
  cells_[after].push_back(id);
}

std::vector<Pose2> KeyframeGraph::Poses() const {
  std::vector<Pose2> poses;
  poses.reserve(nodes_.size());
  for (const Node& node : nodes_) poses.push_back(node.T_map_base);
  return poses;
}

std::vector<std::int64_t> KeyframeGraph::Near(const Eigen::Vector2d& p_map, double radius) const {
  std::vector<std::int64_t> near;
  const auto reach = static_cast<std::int64_t>(std::ceil(radius / cell_));
  const auto column = static_cast<std::int64_t>(std::floor(p_map.x() / cell_));
  const auto row = static_cast<std::int64_t>(std::floor(p_map.y() / cell_));
  for (std::int64_t r = row - reach; r <= row + reach; ++r) {
    for (std::int64_t c = column - reach; c <= column + reach; ++c) {
      const auto cell = cells_.find(CellKey(c, r));
      if (cell == cells_.end()) continue;
      for (const std::int64_t id : cell->second) {
        if ((At(id).T_map_base.Translation() - p_map).norm() <= radius) near.push_back(id);
      }
    }
  }
  std::sort(near.begin(), near.end());
  return near;
}

KeyframeGraph::Relative KeyframeGraph::Along(
    const std::unordered_map<std::int64_t, Reached>& reached, std::int64_t to) const {
  std::vector<Edge> path;  // from `to` back to the start
  for (std::int64_t id = to; reached.at(id).before >= 0; id = reached.at(id).before) {
    const Edge& edge = edges_[reached.at(id).edge];
    path.push_back(edge.to == id ? edge : Reversed(edge));
  }
  Relative relative;
  for (auto step = path.rbegin(); step != path.rend(); ++step) {
    relative.covariance = ComposeCovariance(
        relative.T_from_to, relative.covariance, step->T_from_to, step->information.inverse());
    relative.T_from_to = relative.T_from_to * step->T_from_to;
  }
  return relative;
}

std::unordered_map<std::int64_t, KeyframeGraph::Relative> KeyframeGraph::RelativeTo(
    std::int64_t from, std::span<const std::int64_t> targets) const {
  std::unordered_map<std::int64_t, Reached> reached;
  using Entry = std::pair<double, std::int64_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  reached[from] = {};
  open.emplace(0.0, from);
  std::size_t missing = targets.size();
  std::unordered_map<std::int64_t, Relative> relatives;
  while (!open.empty() && missing > 0) {
    const auto [variance, id] = open.top();
    open.pop();
    Reached& here = reached[id];
    if (here.settled) continue;
    here.settled = true;
    if (std::find(targets.begin(), targets.end(), id) != targets.end()) --missing;
    for (const std::size_t e : At(id).edges) {
      const std::int64_t next = edges_[e].from == id ? edges_[e].to : edges_[e].from;
      const double sum = variance + variances_[e];
      const auto [found, is_new] = reached.try_emplace(next);
      if (!is_new && found->second.variance <= sum) continue;
      found->second = {sum, id, e, false};
      open.emplace(sum, next);
    }
  }
  for (const std::int64_t target : targets) {
    const auto found = reached.find(target);
    if (found != reached.end() && found->second.settled) relatives[target] = Along(reached, target);
  }
  return relatives;
}

}  // namespace ceilmap::graph
