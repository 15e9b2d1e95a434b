#include "mapping/placed_maps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "calib/base/error.hpp"
#include "mapping/map_match.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {
namespace {

using FramePoses = std::unordered_map<std::int64_t, graph::FramePose>;

FramePoses FramePosesOf(const std::vector<graph::Keyframe>& keyframes) {
  FramePoses poses;
  for (const graph::Keyframe& keyframe : keyframes) poses[keyframe.id] = keyframe.pose;
  return poses;
}

bool IsSame(const graph::FramePose& a, const graph::FramePose& b) {
  return a.stamp_s == b.stamp_s && a.T_map_base.x == b.T_map_base.x &&
         a.T_map_base.y == b.T_map_base.y && a.T_map_base.yaw == b.T_map_base.yaw;
}

/// Whether one map is a copy of the other, of which keyframes may be missing.
bool HaveOneFrame(const std::vector<graph::Keyframe>& a, const std::vector<graph::Keyframe>& b) {
  const FramePoses known = FramePosesOf(a);
  const auto same = static_cast<std::size_t>(
      std::count_if(b.begin(), b.end(), [&known](const graph::Keyframe& keyframe) {
        const auto there = known.find(keyframe.id);
        return there != known.end() && IsSame(there->second, keyframe.pose);
      }));
  return 2 * same > std::min(a.size(), b.size());
}

/// Where a pose of b lies on a, by the edges whose keyframes on b are nearest to it.
Pose2 PlacedByEdges(const Pose2& T_b_base,
                    const std::vector<graph::Edge>& edges,
                    const std::vector<Pose2>& T_a_from,
                    const std::vector<Pose2>& T_b_to,
                    double arm) {
  constexpr std::size_t kNearest = 6;
  std::vector<std::pair<double, std::size_t>> order;
  order.reserve(edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    order.emplace_back((T_b_to[i].Translation() - T_b_base.Translation()).squaredNorm(), i);
  }
  const auto end = order.begin() + static_cast<long>(std::min(kNearest, order.size()));
  std::partial_sort(order.begin(), end, order.end());
  std::vector<graph::Edge> near;
  std::vector<Pose2> from;
  std::vector<Pose2> to;
  for (auto at = order.begin(); at != end; ++at) {
    near.push_back(edges[at->second]);
    from.push_back(T_a_from[at->second]);
    to.push_back(T_b_to[at->second]);
  }
  return RelativePose(near, from, to, arm) * T_b_base;
}

}  // namespace

PlacedKeyframes PlacedOn(const NamedMap& a, const NamedMap& b) {
  const std::vector<graph::Keyframe> keyframes_a = a.map->ReadKeyframes();
  PlacedKeyframes placed;
  placed.keyframes = b.map->ReadKeyframes();
  for (graph::Keyframe& keyframe : placed.keyframes) keyframe.heights = {};
  placed.same_frame = HaveOneFrame(keyframes_a, placed.keyframes);
  if (placed.same_frame) return placed;
  const MapMatch match = MatchMaps(a, b);
  if (!match.result.ok()) {
    throw RunError(
        fmt::format("{} and {} cannot be compared: {}", a.name, b.name, match.result.reason));
  }
  const std::vector<graph::Edge>& edges = match.result.edges;
  const FramePoses poses_a = FramePosesOf(keyframes_a);
  const FramePoses poses_b = FramePosesOf(placed.keyframes);
  std::vector<Pose2> T_a_from;
  std::vector<Pose2> T_b_to;
  T_a_from.reserve(edges.size());
  T_b_to.reserve(edges.size());
  for (const graph::Edge& edge : edges) {
    T_a_from.push_back(poses_a.at(edge.from).T_map_base);
    T_b_to.push_back(poses_b.at(edge.to).T_map_base);
  }
  placed.T_a_b = match.result.T_a_b;
  placed.edges = static_cast<int>(edges.size());
  const double arm = SpanOf(ViewOf(a.map->Metadata()));
  for (graph::Keyframe& keyframe : placed.keyframes) {
    Pose2& pose = keyframe.pose.T_map_base;
    pose = PlacedByEdges(pose, edges, T_a_from, T_b_to, arm);
  }
  return placed;
}

}  // namespace ceilmap::mapping
