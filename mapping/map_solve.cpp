#include "mapping/map_solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <optional>
#include <unordered_map>

#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "mapping/graph/fingerprint.hpp"
#include "mapping/history_union.hpp"
#include "mapping/map_links.hpp"
#include "mapping/map_parts.hpp"

namespace ceilmap::mapping {
namespace {

/// A match between two of the maps, by their indices, its edges by the ids of the union. a is
/// before b in the order of the fingerprints, so that the order of the maps makes no difference.
struct PartMatch {
  std::size_t a = 0;
  std::size_t b = 0;
  std::string name;
  JoinResult result;
};

class MapSolver {
 public:
  MapSolver(const std::vector<NamedMap>& maps,
            const std::vector<NamedMatch>& matches,
            const graph::PoseGraphParams& params);

  SolvedMaps Run();

 private:
  void OrderMaps();
  [[nodiscard]] std::size_t FindMap(const MatchedMap& map, const std::string& match) const;
  void AddMatch(const NamedMatch& named);
  void MakeLinks();
  [[nodiscard]] MapLink LinkOf(const PartMatch& match) const;
  [[nodiscard]] graph::MapGraph Union(const MapGroup& group) const;
  [[nodiscard]] std::optional<std::size_t> WorstMatch(const MapGroup& group,
                                                      const graph::MapGraph& optimum,
                                                      std::string& reason) const;
  void Contradict(std::size_t link, const std::string& reason);
  void NameLeftOut();
  [[nodiscard]] std::string ReasonFor(std::size_t map) const;

  const std::vector<NamedMap>& maps_;
  graph::PoseGraphParams params_;
  PartGraphs parts_;
  std::unordered_map<std::int64_t, Pose2> poses_;  // on their own maps
  std::vector<std::uint64_t> fingerprints_;
  std::vector<std::size_t> by_rank_;  // maps in the order of their fingerprints
  std::vector<std::size_t> rank_;     // the inverse
  double span_ = INFINITY;            // smallest of the maps
  std::vector<PartMatch> matches_;
  std::vector<std::size_t> link_match_;  // match of each link
  std::vector<LinkedMap> linked_;        // by rank
  std::vector<MapLink> links_;           // between ranks
  std::vector<std::size_t> excluded_;    // links
  SolvedMaps solved_;
};

double ExtentOf(const graph::MapGraph& graph) {
  Eigen::AlignedBox2d box;
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    box.extend(keyframe.pose.T_map_base.Translation());
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

MapSolver::MapSolver(const std::vector<NamedMap>& maps,
                     const std::vector<NamedMatch>& matches,
                     const graph::PoseGraphParams& params)
    : maps_(maps), params_(params), parts_(ReadGraphs(maps)) {
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const store::MapMetadata& metadata = maps[i].map->Metadata();
    const store::MapMetadata& first = maps.front().map->Metadata();
    if (metadata.unit != first.unit) {
      throw InputError(fmt::format(
          "{} and {}: {}", maps.front().name, maps[i].name, Incompatibility(first, metadata)));
    }
    const int side = std::max(metadata.view_size.width, metadata.view_size.height);
    span_ = std::min(span_, side * metadata.view_units_per_px);
    for (const graph::Keyframe& keyframe : parts_.graphs[i].keyframes) {
      poses_[keyframe.id] = keyframe.pose.T_map_base;
    }
  }
  OrderMaps();
  for (const NamedMatch& named : matches) AddMatch(named);
  MakeLinks();
}

void MapSolver::OrderMaps() {
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    graph::MapGraph& graph = parts_.graphs[i];
    Renumber(graph, -parts_.ids.first[i]);
    fingerprints_.push_back(graph::Fingerprint(graph.keyframes, graph.edges));
    Renumber(graph, parts_.ids.first[i]);
  }
  by_rank_.resize(maps_.size());
  std::iota(by_rank_.begin(), by_rank_.end(), std::size_t{0});
  std::sort(by_rank_.begin(), by_rank_.end(), [this](std::size_t x, std::size_t y) {
    return fingerprints_[x] < fingerprints_[y];
  });
  rank_.resize(maps_.size());
  for (std::size_t rank = 0; rank < by_rank_.size(); ++rank) {
    rank_[by_rank_[rank]] = rank;
    if (rank > 0 && fingerprints_[by_rank_[rank]] == fingerprints_[by_rank_[rank - 1]]) {
      throw InputError(fmt::format("{} and {} are the same map; give it once",
                                   maps_[by_rank_[rank - 1]].name,
                                   maps_[by_rank_[rank]].name));
    }
  }
}

std::size_t MapSolver::FindMap(const MatchedMap& map, const std::string& match) const {
  const auto found = std::find(fingerprints_.begin(), fingerprints_.end(), map.fingerprint);
  if (found != fingerprints_.end()) {
    return static_cast<std::size_t>(found - fingerprints_.begin());
  }
  for (const NamedMap& named : maps_) {
    if (std::filesystem::path(named.name).filename() != map.name) continue;
    throw InputError(fmt::format(
        "{}: was made of another version of {}; run 'ceilmap match' again", match, named.name));
  }
  throw InputError(fmt::format(
      "{}: is about {}, which is not among the maps; give this map too, leave the file out, or run "
      "'ceilmap match' again",
      match,
      Shown(map.name)));
}

void MapSolver::AddMatch(const NamedMatch& named) {
  PartMatch match{FindMap(named.match.a, named.name),
                  FindMap(named.match.b, named.name),
                  named.name,
                  named.match.result};
  for (graph::Edge& edge : match.result.edges) {
    edge.from += parts_.ids.first[match.a];
    edge.to += parts_.ids.first[match.b];
    const bool known = poses_.contains(edge.from) && poses_.contains(edge.to) &&
                       parts_.ids.PartOf(edge.from) == match.a &&
                       parts_.ids.PartOf(edge.to) == match.b;
    if (!known) {
      throw InputError(
          fmt::format("{}: has an edge of a keyframe that {} or {} does not have; run "
                      "'ceilmap match' again",
                      named.name,
                      maps_[match.a].name,
                      maps_[match.b].name));
    }
  }
  if (rank_[match.a] > rank_[match.b]) {
    std::swap(match.a, match.b);
    for (graph::Edge& edge : match.result.edges) edge = graph::Reversed(edge);
  }
  for (const PartMatch& other : matches_) {
    if (other.a != match.a || other.b != match.b) continue;
    throw InputError(fmt::format(
        "{} and {} are about the same two maps; give one of them", other.name, match.name));
  }
  matches_.push_back(std::move(match));
}

MapLink MapSolver::LinkOf(const PartMatch& match) const {
  constexpr std::size_t kSamples = 32;
  const std::vector<graph::Edge>& edges = match.result.edges;
  MapLink link{rank_[match.a], rank_[match.b], edges.size(), {}, {}};
  std::vector<Pose2> T_a_from;
  std::vector<Pose2> T_b_to;
  const std::size_t step = std::max<std::size_t>(1, edges.size() / kSamples);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    T_a_from.push_back(poses_.at(edges[i].from));
    T_b_to.push_back(poses_.at(edges[i].to));
    if (i % step != 0) continue;
    link.samples.push_back({T_a_from.back() * edges[i].T_from_to, T_b_to.back()});
  }
  link.T_a_b = RelativePose(edges, T_a_from, T_b_to, span_);
  return link;
}

void MapSolver::MakeLinks() {
  std::sort(matches_.begin(), matches_.end(), [this](const PartMatch& x, const PartMatch& y) {
    return std::pair(rank_[x.a], rank_[x.b]) < std::pair(rank_[y.a], rank_[y.b]);
  });
  for (const std::size_t map : by_rank_) {
    const graph::MapGraph& graph = parts_.graphs[map];
    linked_.push_back({graph.keyframes.size(), ExtentOf(graph)});
  }
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    if (!matches_[i].result.ok()) continue;
    links_.push_back(LinkOf(matches_[i]));
    link_match_.push_back(i);
  }
}

/// The graph of a group, each map at its pose in the frame of the first one given.
graph::MapGraph MapSolver::Union(const MapGroup& group) const {
  std::vector<std::pair<std::size_t, Pose2>> placed;
  for (std::size_t i = 0; i < group.maps.size(); ++i) {
    placed.emplace_back(by_rank_[group.maps[i]], group.T_first_map[i]);
  }
  std::sort(
      placed.begin(), placed.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  const Pose2 T_frame_first = placed.front().second.Inverse();
  graph::MapGraph all;
  for (const auto& [map, T_first_map] : placed) {
    graph::MapGraph part = parts_.graphs[map];
    graph::MoveAll(part, T_frame_first * T_first_map);
    all.edges.insert(all.edges.end(), part.edges.begin(), part.edges.end());
    AppendPart(all, part);
  }
  for (const std::size_t link : group.links) {
    const JoinResult& result = matches_[link_match_[link]].result;
    all.edges.insert(all.edges.end(), result.edges.begin(), result.edges.end());
    all.quality.loops.compared += result.compared;
    all.quality.loops.accepted += static_cast<std::int64_t>(result.edges.size());
  }
  return all;
}

/// The link of which the optimum removed most edges, if it removed too many, and the reason.
std::optional<std::size_t> MapSolver::WorstMatch(const MapGroup& group,
                                                 const graph::MapGraph& optimum,
                                                 std::string& reason) const {
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> kept;
  for (const graph::Edge& edge : optimum.edges) {
    std::size_t a = parts_.ids.PartOf(edge.from);
    std::size_t b = parts_.ids.PartOf(edge.to);
    if (rank_[a] > rank_[b]) std::swap(a, b);
    ++kept[{rank_[a], rank_[b]}];
  }
  std::optional<std::size_t> worst;
  double worst_ratio = kMaxOutlierRatio;
  for (const std::size_t link : group.links) {
    const std::size_t bad = links_[link].edges - kept[{links_[link].a, links_[link].b}];
    const double ratio = static_cast<double>(bad) / static_cast<double>(links_[link].edges);
    if (ratio <= worst_ratio) continue;
    worst = link;
    worst_ratio = ratio;
    reason = ContradictionReason(static_cast<std::int64_t>(links_[link].edges),
                                 static_cast<std::int64_t>(bad));
  }
  return worst;
}

void MapSolver::Contradict(std::size_t link, const std::string& reason) {
  excluded_.push_back(link);
  PartMatch& match = matches_[link_match_[link]];
  match.result.verdict = JoinResult::Verdict::kContradicts;
  match.result.reason = reason;
  solved_.contradictions.push_back({match.a, match.b, reason});
}

/// Why a map is in no group with the others.
std::string MapSolver::ReasonFor(std::size_t map) const {
  std::vector<std::string> friends;
  std::map<JoinResult::Verdict, std::vector<const PartMatch*>> others;
  for (const PartMatch& match : matches_) {
    if (match.a != map && match.b != map) continue;
    const std::size_t other = match.a == map ? match.b : match.a;
    if (match.result.ok()) friends.push_back(maps_[other].name);
    others[match.result.verdict].push_back(&match);
  }
  if (!friends.empty()) {
    return fmt::format("it joins only {}, which do not join the rest", fmt::join(friends, ", "));
  }
  for (const auto verdict : {JoinResult::Verdict::kContradicts, JoinResult::Verdict::kAmbiguous}) {
    if (others[verdict].empty()) continue;
    const PartMatch& match = *others[verdict].front();
    const std::size_t other = match.a == map ? match.b : match.a;
    return fmt::format("with {}: {}", maps_[other].name, match.result.reason);
  }
  const auto& apart = others[JoinResult::Verdict::kNoOverlap];
  if (apart.empty()) {
    return "no edges file is about it; run 'ceilmap match' with a map that it overlaps";
  }
  if (apart.size() == 1) return apart.front()->result.reason;
  return fmt::format("it has no sufficient overlap with any of {} maps", apart.size());
}

void MapSolver::NameLeftOut() {
  for (std::size_t map = 0; map < maps_.size(); ++map) {
    if (std::binary_search(solved_.joined.begin(), solved_.joined.end(), map)) continue;
    solved_.left_out.push_back({map, ReasonFor(map)});
  }
}

SolvedMaps MapSolver::Run() {
  for (;;) {
    const LinkChoice choice = ChooseLinks(linked_, links_, excluded_, span_);
    for (const std::size_t link : choice.contradicting) {
      Contradict(link, "they contradict the other maps: the poses of maps in a cycle do not close");
    }
    solved_.joined.clear();
    for (const std::size_t map : choice.group.maps) solved_.joined.push_back(by_rank_[map]);
    std::sort(solved_.joined.begin(), solved_.joined.end());
    if (solved_.joined.size() < 2 && maps_.size() > 1) solved_.joined.clear();
    if (solved_.joined.empty()) break;
    graph::MapGraph all = Union(choice.group);
    graph::Optimize(all, params_);
    std::string reason;
    const std::optional<std::size_t> worst = WorstMatch(choice.group, all, reason);
    if (!worst) {
      graph::FindWeakSpots(all, span_);
      solved_.graph = std::move(all);
      break;
    }
    Contradict(*worst, reason);
  }
  NameLeftOut();
  solved_.first_ids = parts_.ids.first;
  return std::move(solved_);
}

/// The histories of the joined maps.
store::MapHistory HistoryOf(const SolvedMaps& solved, const std::vector<NamedMap>& maps) {
  std::vector<PartHistory> parts;
  for (const std::size_t map : solved.joined) {
    PartHistory part{maps[map].map->ReadHistory(), maps[map].map->ReadKeyframes()};
    for (graph::Keyframe& keyframe : part.keyframes) keyframe.id += solved.first_ids[map];
    parts.push_back(std::move(part));
  }
  return UniteHistories(std::move(parts), solved.graph);
}

}  // namespace

SolvedMaps SolveMaps(const std::vector<NamedMap>& maps,
                     const std::vector<NamedMatch>& matches,
                     const graph::PoseGraphParams& params) {
  return MapSolver(maps, matches, params).Run();
}

graph::MapGraph WriteSolvedGraph(const SolvedMaps& solved,
                                 const std::vector<NamedMap>& maps,
                                 const CommonView& view,
                                 store::MapWriter& writer) {
  graph::MapGraph graph = solved.graph;
  const PartIds ids{solved.first_ids};
  ToCommonView(maps, view, ids, graph);
  PartImages images(maps, view, ids, {&graph, 1});
  for (const graph::Keyframe& keyframe : graph.keyframes) images.Write(keyframe.id, writer);
  writer.WriteGraph(graph);
  writer.WriteHistory(HistoryOf(solved, maps));
  return graph;
}

mosaic::WrittenMap WriteSolved(const SolvedMaps& solved,
                               const std::vector<NamedMap>& maps,
                               const CommonView& view,
                               const store::MapMetadata& metadata,
                               const MapperParams& params,
                               store::MapWriter& writer,
                               const UnionProgress& progress) {
  const graph::MapGraph graph = WriteSolvedGraph(solved, maps, view, writer);
  const mosaic::MosaicRenderer renderer(
      graph.keyframes,
      metadata,
      [&writer](std::int64_t id) { return writer.ReadImage(id); },
      mosaic::ParamsFor(metadata, params.mosaic));
  return mosaic::WriteMosaic(renderer, writer, progress);
}

}  // namespace ceilmap::mapping
