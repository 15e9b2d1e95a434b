#include "mapping/graph/frame_ties.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "calib/base/pose_with_covariance.hpp"

namespace ceilmap::graph {
namespace {

/// The nearest matrix without negative eigenvalues.
Eigen::Matrix3d Positive(const Eigen::Matrix3d& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(0.5 * (matrix + matrix.transpose()));
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).asDiagonal() *
         solver.eigenvectors().transpose();
}

}  // namespace

KeyframesById ById(const std::vector<Keyframe>& keyframes) {
  KeyframesById by_id;
  by_id.reserve(keyframes.size());
  for (const Keyframe& keyframe : keyframes) by_id[keyframe.id] = &keyframe;
  return by_id;
}

std::vector<Tie> Ties(const MapGraph& graph) {
  const KeyframesById keyframes = ById(graph.keyframes);
  std::vector<Tie> ties;
  ties.reserve(graph.trajectory.size());
  for (const FramePose& frame : graph.trajectory) {
    const FramePose& keyframe = keyframes.at(frame.keyframe_id)->pose;
    Tie tie;
    tie.T_keyframe_frame = keyframe.T_map_base.Inverse() * frame.T_map_base;
    const Eigen::Matrix3d inherited = ComposeCovariance(
        keyframe.T_map_base, keyframe.covariance, tie.T_keyframe_frame, Eigen::Matrix3d::Zero());
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = keyframe.T_map_base.Rotation();
    tie.covariance = Positive(turn.transpose() * (frame.covariance - inherited) * turn);
    ties.push_back(tie);
  }
  return ties;
}

Legs LegsOf(const MapGraph& graph) {
  std::unordered_set<std::int64_t> joined;  // keyframes that have a tie to the one before
  std::unordered_set<std::int64_t> by_wheels;
  for (const Edge& edge : graph.edges) {
    if (edge.kind == Edge::Kind::kLoopClosure || edge.to != edge.from + 1) continue;
    joined.insert(edge.to);
    if (edge.kind == Edge::Kind::kWheels) by_wheels.insert(edge.to);
  }
  Legs legs;
  for (std::size_t i = 1; i < graph.keyframes.size(); ++i) {
    const Keyframe& from = graph.keyframes[i - 1];
    const Keyframe& to = graph.keyframes[i];
    if (to.id != from.id + 1 || !joined.contains(to.id)) continue;
    legs[from.id] = {from.pose.T_map_base.Inverse() * to.pose.T_map_base,
                     to.id,
                     from.pose.frame_index,
                     to.pose.frame_index,
                     by_wheels.contains(to.id)};
  }
  return legs;
}

const Leg* LegOf(const Legs& legs, const FramePose& frame) {
  const auto leg = legs.find(frame.keyframe_id);
  if (leg == legs.end()) return nullptr;
  const bool shares = !leg->second.by_wheels || frame.status == TrackingStatus::kPredicted;
  return shares ? &leg->second : nullptr;
}

Pose2 Stretched(const Pose2& T_keyframe_frame,
                std::int64_t frame_index,
                const Leg& leg,
                const Pose2& T_keyframe_next) {
  if (frame_index < leg.first_frame || frame_index > leg.next_frame) return T_keyframe_frame;
  const Pose2& before = leg.T_keyframe_next;
  const double way = before.Translation().norm();
  constexpr double kTurning = 0.2;  // rad; less of a turn, and the distance shows the progress
  const double part =
      way > 0 && std::abs(before.yaw) < kTurning
          ? T_keyframe_frame.Translation().norm() / way
          : static_cast<double>(frame_index - leg.first_frame) /
                std::max<double>(1, static_cast<double>(leg.next_frame - leg.first_frame));
  const double share = std::min(1.0, part);
  return {T_keyframe_frame.x + share * (T_keyframe_next.x - before.x),
          T_keyframe_frame.y + share * (T_keyframe_next.y - before.y),
          WrapAngle(T_keyframe_frame.yaw + share * WrapAngle(T_keyframe_next.yaw - before.yaw))};
}

void PlaceFrames(MapGraph& graph,
                 const std::vector<Tie>& ties,
                 const Legs& legs,
                 double variance_factor) {
  const KeyframesById keyframes = ById(graph.keyframes);
  for (std::size_t i = 0; i < ties.size(); ++i) {
    FramePose& frame = graph.trajectory[i];
    const FramePose& keyframe = keyframes.at(frame.keyframe_id)->pose;
    Pose2 T_keyframe_frame = ties[i].T_keyframe_frame;
    if (const Leg* const leg = LegOf(legs, frame)) {
      const Pose2& T_map_next = keyframes.at(leg->next_id)->pose.T_map_base;
      T_keyframe_frame = Stretched(
          T_keyframe_frame, frame.frame_index, *leg, keyframe.T_map_base.Inverse() * T_map_next);
    }
    frame.T_map_base = keyframe.T_map_base * T_keyframe_frame;
    frame.covariance = ComposeCovariance(keyframe.T_map_base,
                                         keyframe.covariance,
                                         T_keyframe_frame,
                                         variance_factor * ties[i].covariance);
  }
}

}  // namespace ceilmap::graph
