#include "mapping/map_merge.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "calib/base/pose_with_covariance.hpp"
#include "mapping/map_parts.hpp"

namespace ceilmap::mapping {
namespace {

std::vector<std::int64_t> Ids(const graph::MapGraph& graph) {
  std::vector<std::int64_t> ids;
  for (const graph::Keyframe& keyframe : graph.keyframes) ids.push_back(keyframe.id);
  return ids;
}

/// Moves a part into the frame of the joined ones and adds the edges between them.
void Attach(LoopCloser& closer, const std::vector<std::int64_t>& part, const JoinResult& join) {
  for (const std::int64_t id : part) {
    closer.Graph().Move(id, join.T_a_b * closer.Graph().T_map_base(id));
  }
  for (const graph::Edge& edge : join.edges) closer.Add(edge);
  for (const std::int64_t id : part) closer.Close(id);
}

/// Puts back poses and covariances of a part that was held. The other keyframes were placed
/// relative to it; they take over the covariance of the nearest of its keyframes.
/// @param part  its keyframes and frames stand first in `merged`.
void Restore(const graph::MapGraph& part, graph::MapGraph& merged) {
  std::copy(part.keyframes.begin(), part.keyframes.end(), merged.keyframes.begin());
  std::copy(part.trajectory.begin(), part.trajectory.end(), merged.trajectory.begin());
  const auto take_over = [&](graph::FramePose& pose) {
    const graph::Keyframe* nearest = &part.keyframes.front();
    const auto distance = [&](const graph::Keyframe& keyframe) {
      return (keyframe.pose.T_map_base.Translation() - pose.T_map_base.Translation()).norm();
    };
    for (const graph::Keyframe& keyframe : part.keyframes) {
      if (distance(keyframe) < distance(*nearest)) nearest = &keyframe;
    }
    const Pose2& T_map_near = nearest->pose.T_map_base;
    pose.covariance += ComposeCovariance(T_map_near,
                                         nearest->pose.covariance,
                                         T_map_near.Inverse() * pose.T_map_base,
                                         Eigen::Matrix3d::Zero());
  };
  for (std::size_t i = part.keyframes.size(); i < merged.keyframes.size(); ++i) {
    take_over(merged.keyframes[i].pose);
  }
  for (std::size_t i = part.trajectory.size(); i < merged.trajectory.size(); ++i) {
    take_over(merged.trajectory[i]);
  }
}

}  // namespace

void Renumber(graph::MapGraph& graph, std::int64_t offset) {
  for (graph::Keyframe& keyframe : graph.keyframes) {
    keyframe.id += offset;
    keyframe.pose.keyframe_id += offset;
  }
  for (graph::FramePose& frame : graph.trajectory) frame.keyframe_id += offset;
  for (graph::WeakSpot& spot : graph.weak_spots) spot.keyframe_id += offset;
  for (graph::Edge& edge : graph.edges) {
    edge.from += offset;
    edge.to += offset;
  }
}

void ChangeBases(graph::Edge& edge, const Pose2& T_own_new_from, const Pose2& T_own_new_to) {
  const Pose2 T = edge.T_from_to;
  edge.T_from_to = T_own_new_from.Inverse() * T * T_own_new_to;
  // d(new) = J d(old): the lever arm at the `to` end turns with the edge's yaw; then everything
  // is expressed in the new `from` base.
  const Eigen::Vector2d arm = T.Rotation() * T_own_new_to.Translation();
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
  jacobian(0, 2) = -arm.y();
  jacobian(1, 2) = arm.x();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = T_own_new_from.Rotation().transpose();
  const Eigen::Matrix3d back = (turn * jacobian).inverse();
  edge.information = back.transpose() * edge.information * back;
}

void ChangeBase(graph::Keyframe& keyframe, const Pose2& T_own_new) {
  // The new base is attached rigidly to the old one.
  Eigen::Matrix3d by_own = Eigen::Matrix3d::Identity();
  const Eigen::Vector2d arm = keyframe.pose.T_map_base.Rotation() * T_own_new.Translation();
  by_own(0, 2) = -arm.y();
  by_own(1, 2) = arm.x();
  keyframe.pose.covariance = by_own * keyframe.pose.covariance * by_own.transpose();
  keyframe.pose.T_map_base = keyframe.pose.T_map_base * T_own_new;
}

void ChangeView(graph::MapGraph& graph, const Pose2& T_base_view_own, const Pose2& T_base_view) {
  const Pose2 T_own_new = T_base_view_own * T_base_view.Inverse();
  for (graph::Keyframe& keyframe : graph.keyframes) ChangeBase(keyframe, T_own_new);
  for (graph::Edge& edge : graph.edges) ChangeBases(edge, T_own_new, T_own_new);
}

JoinedParts JoinAll(LoopCloser& closer,
                    const std::vector<std::vector<std::int64_t>>& parts,
                    const DescriptorSource& descriptors,
                    JoinLight light) {
  JoinedParts all;
  if (parts.empty()) return all;
  all.results.resize(parts.size());
  all.results.front().verdict = JoinResult::Verdict::kJoined;
  all.joined = {0};
  std::vector<std::int64_t> base = parts.front();
  // A part that fits nowhere may fit after another part was joined; so all are tried again after
  // each success.
  for (bool grown = true; grown;) {
    grown = false;
    for (std::size_t i = 1; i < parts.size(); ++i) {
      if (all.results[i].ok()) continue;
      all.results[i] = JoinParts(closer, base, parts[i], descriptors, light);
      all.loops.compared += all.results[i].compared;
      all.loops.accepted += static_cast<std::int64_t>(all.results[i].edges.size());
      if (!all.results[i].ok()) continue;
      Attach(closer, parts[i], all.results[i]);
      base.insert(base.end(), parts[i].begin(), parts[i].end());
      all.joined.push_back(i);
      grown = true;
    }
    if (all.joined.size() == parts.size()) break;
  }
  return all;
}

bool MergeResult::ok() const {
  return std::all_of(results.begin(), results.end(), [](const JoinResult& r) { return r.ok(); });
}

MergeResult MergeGraphs(const calib::CeilingView& view,
                        const std::vector<graph::MapGraph>& parts,
                        const graph::ImageLoader& load,
                        const DescriptorSource& descriptors,
                        const LoopCloserParams& loops,
                        const graph::PoseGraphParams& pose_graph,
                        HeldPoses held) {
  LoopCloser closer(view, load, loops);
  std::vector<std::vector<std::int64_t>> ids;
  std::unordered_map<std::int64_t, std::size_t> part_of;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    ids.push_back(Ids(parts[i]));
    for (const graph::Keyframe& keyframe : parts[i].keyframes) {
      closer.Add(keyframe);
      part_of[keyframe.id] = i;
    }
    for (const graph::Edge& edge : parts[i].edges) closer.Add(edge);
  }
  const JoinedParts joined = JoinAll(closer, ids, descriptors);

  MergeResult merged;
  merged.results = joined.results;
  for (const std::size_t i : joined.joined) AppendPart(merged.graph, parts[i]);
  std::sort(merged.graph.keyframes.begin(),
            merged.graph.keyframes.end(),
            [](const graph::Keyframe& x, const graph::Keyframe& y) { return x.id < y.id; });
  std::int64_t across = 0;
  for (const graph::Edge& edge : closer.Graph().Edges()) {
    if (!merged.results[part_of.at(edge.from)].ok()) continue;
    merged.graph.edges.push_back(edge);
    across += part_of.at(edge.from) != part_of.at(edge.to) ? 1 : 0;
  }
  merged.graph.quality.loops += joined.loops;
  merged.graph.quality.loops += closer.Counts();
  graph::MoveKeyframes(merged.graph, closer.Graph().Poses());
  const std::int64_t outliers = merged.graph.quality.loops.outliers;
  const bool holds_first = held == HeldPoses::kFirstPart && !parts.front().keyframes.empty();
  graph::Optimize(
      merged.graph, pose_graph, holds_first ? ids.front() : std::vector<std::int64_t>());
  if (holds_first) Restore(parts.front(), merged.graph);
  const std::int64_t bad = merged.graph.quality.loops.outliers - outliers;
  if (across > 0 && static_cast<double>(bad) > kMaxOutlierRatio * static_cast<double>(across)) {
    JoinResult& last = merged.results[joined.joined.back()];
    last.verdict = JoinResult::Verdict::kContradicts;
    last.reason = ContradictionReason(across, bad);
  }
  graph::FindWeakSpots(merged.graph, closer.Span());
  return merged;
}

}  // namespace ceilmap::mapping
