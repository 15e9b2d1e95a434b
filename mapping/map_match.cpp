#include "mapping/map_match.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <unordered_map>

#include "calib/base/error.hpp"
#include "calib/base/planar_fit.hpp"
#include "mapping/graph/fingerprint.hpp"
#include "mapping/map_merge.hpp"
#include "mapping/map_parts.hpp"
#include "mapping/place_overlap.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {
namespace {

MatchedMap Identity(const std::string& name,
                    std::span<const graph::Keyframe> keyframes,
                    std::span<const graph::Edge> edges) {
  return {std::filesystem::path(name).filename().string(), graph::Fingerprint(keyframes, edges)};
}

/// The edges of a joined graph from part 0 to part 1, by the ids and between the bases of the maps.
std::vector<graph::Edge> EdgesAcross(const graph::MapGraph& joined,
                                     const PartIds& ids,
                                     const Pose2& T_base_view_b,
                                     const Pose2& T_base_view) {
  std::vector<graph::Edge> across;
  for (graph::Edge edge : joined.edges) {
    if (ids.PartOf(edge.from) == ids.PartOf(edge.to)) continue;
    if (ids.PartOf(edge.from) != 0) edge = graph::Reversed(edge);
    ChangeBases(edge, {}, T_base_view * T_base_view_b.Inverse());
    edge.to -= ids.first[1];
    across.push_back(edge);
  }
  return across;
}

/// @param a, b  graphs of the maps, by their own ids.
Pose2 FitPose(const std::vector<graph::Edge>& edges,
              const std::unordered_map<std::int64_t, Pose2>& a,
              const std::unordered_map<std::int64_t, Pose2>& b,
              double arm) {
  std::vector<Pose2> T_a_from;
  std::vector<Pose2> T_b_to;
  for (const graph::Edge& edge : edges) {
    T_a_from.push_back(a.at(edge.from));
    T_b_to.push_back(b.at(edge.to));
  }
  return RelativePose(edges, T_a_from, T_b_to, arm);
}

std::unordered_map<std::int64_t, Pose2> PosesOf(const graph::MapGraph& graph,
                                                std::int64_t first_id) {
  std::unordered_map<std::int64_t, Pose2> poses;
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    poses[keyframe.id - first_id] = keyframe.pose.T_map_base;
  }
  return poses;
}

}  // namespace

MatchedMap IdentityOf(const NamedMap& map) {
  return Identity(map.name, map.map->ReadKeyframes(), map.map->ReadEdges());
}

Pose2 RelativePose(const std::vector<graph::Edge>& edges,
                   const std::vector<Pose2>& T_a_from,
                   const std::vector<Pose2>& T_b_to,
                   double arm) {
  std::vector<PointPair> pairs;
  pairs.reserve(2 * edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (const Eigen::Vector2d& p : {Eigen::Vector2d(0, 0), Eigen::Vector2d(arm, 0)}) {
      pairs.push_back({T_a_from[i] * edges[i].T_from_to * p, T_b_to[i] * p});
    }
  }
  return FitPlane(pairs, false).value().S_a_b.motion;
}

MapMatch MatchMaps(const NamedMap& a, const NamedMap& b, const MapperParams& params) {
  const std::vector<NamedMap> maps = {a, b};
  const CommonView view(maps);
  PartGraphs parts = ReadGraphs(maps);
  MapMatch match;
  match.a = Identity(a.name, parts.graphs[0].keyframes, parts.graphs[0].edges);
  match.b = IdentityOf(b);
  if (match.a.fingerprint == match.b.fingerprint) {
    throw InputError(fmt::format("{} and {} are the same map; give two maps", a.name, b.name));
  }
  const auto poses_a = PosesOf(parts.graphs[0], 0);
  const auto poses_b = PosesOf(parts.graphs[1], parts.ids.first[1]);
  for (graph::MapGraph& graph : parts.graphs) ToCommonView(maps, view, parts.ids, graph);
  PartImages images(maps, view, parts.ids, parts.graphs);
  const DescriptorSource descriptors = [&](std::int64_t id) { return images.Descriptors(id); };
  if (!MayMeet(view.View(), parts.graphs[0].keyframes, parts.graphs[1].keyframes, descriptors)) {
    match.result.reason = "no overlap found: no image of one map looks like one of the other";
    return match;
  }
  const std::int64_t compared_before =
      parts.graphs[0].quality.loops.compared + parts.graphs[1].quality.loops.compared;
  const MergeResult merged = MergeGraphs(
      view.View(),
      parts.graphs,
      [&](std::int64_t id) { return images.Image(id); },
      descriptors,
      LoopParams(params, view.View(), view.Metadata()),
      params.pose_graph);
  match.result = merged.results[1];
  match.result.compared = static_cast<int>(merged.graph.quality.loops.compared - compared_before);
  match.result.edges.clear();
  if (!merged.ok()) return match;
  match.result.edges = EdgesAcross(
      merged.graph, parts.ids, b.map->Metadata().T_base_view, view.Metadata().T_base_view);
  match.result.T_a_b = FitPose(match.result.edges, poses_a, poses_b, SpanOf(view.View()));
  return match;
}

}  // namespace ceilmap::mapping
