#include "mapping/map_links.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "calib/base/statistics.hpp"

namespace ceilmap::mapping {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
constexpr double kMaxGapSpans = 0.5;   // of a cycle of links that closes, plus ...
constexpr double kMaxGapRatio = 0.01;  // ... this part of the extent of its maps
constexpr double kMaxGapRad = 0.2;

/// The spanning forest of the heaviest links.
class LinkForest {
 public:
  LinkForest(const std::vector<LinkedMap>& maps,
             const std::vector<MapLink>& links,
             const std::set<std::size_t>& unused,
             double span)
      : maps_(maps), links_(links), span_(span), nodes_(maps.size()) {
    std::vector<std::size_t> order(links.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::erase_if(order, [&](std::size_t link) { return unused.contains(link); });
    std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) {
      return links[x].edges > links[y].edges;
    });
    std::vector<std::vector<std::size_t>> tree(maps.size());
    std::vector<std::size_t> root(maps.size());
    std::iota(root.begin(), root.end(), std::size_t{0});
    for (const std::size_t link : order) {
      const std::size_t from = root[links[link].a];
      const std::size_t to = root[links[link].b];
      if (from == to) {
        others_.push_back(link);
        continue;
      }
      std::replace(root.begin(), root.end(), std::max(from, to), std::min(from, to));
      tree[links[link].a].push_back(link);
      tree[links[link].b].push_back(link);
    }
    for (std::size_t map = 0; map < maps.size(); ++map) {
      if (root[map] == map) Place(map, tree);
    }
  }

  /// The links outside of the forest.
  [[nodiscard]] const std::vector<std::size_t>& Others() const { return others_; }
  [[nodiscard]] std::size_t RootOf(std::size_t map) const { return nodes_[map].root; }
  [[nodiscard]] const Pose2& T_root_map(std::size_t map) const { return nodes_[map].T_root_map; }

  /// Links of the forest on the way between the two maps of a link.
  [[nodiscard]] std::vector<std::size_t> Way(const MapLink& link) const {
    std::vector<std::size_t> way;
    std::size_t a = link.a;
    std::size_t b = link.b;
    while (a != b) {
      std::size_t& deeper = nodes_[a].depth >= nodes_[b].depth ? a : b;
      way.push_back(nodes_[deeper].link);
      deeper = nodes_[deeper].parent;
    }
    return way;
  }

  /// Whether a link agrees with the poses of its two maps, which are in one tree.
  [[nodiscard]] bool Agrees(const MapLink& link) const {
    std::set<std::size_t> on_the_way = {link.a, link.b};
    for (const std::size_t passed : Way(link)) {
      on_the_way.insert({links_[passed].a, links_[passed].b});
    }
    double extent = 0;
    for (const std::size_t map : on_the_way) extent += maps_[map].extent;
    const Pose2 T_a_b = nodes_[link.a].T_root_map.Inverse() * nodes_[link.b].T_root_map;
    std::vector<double> gaps;
    std::vector<double> turns;
    for (const LinkSample& sample : link.samples) {
      const Pose2 off = sample.T_a_here.Inverse() * (T_a_b * sample.T_b_here);
      gaps.push_back(off.Translation().norm());
      turns.push_back(std::abs(off.yaw));
    }
    return ceilmap::Median(std::move(gaps)) <= kMaxGapSpans * span_ + kMaxGapRatio * extent &&
           ceilmap::Median(std::move(turns)) <= kMaxGapRad;
  }

 private:
  struct Node {
    std::size_t root = kNone;
    std::size_t parent = kNone;
    std::size_t link = kNone;  // to the parent
    std::size_t depth = 0;
    Pose2 T_root_map;
  };

  /// Gives a tree's maps their poses, from its root on.
  void Place(std::size_t root, const std::vector<std::vector<std::size_t>>& tree) {
    nodes_[root].root = root;
    std::vector<std::size_t> reached = {root};
    for (std::size_t i = 0; i < reached.size(); ++i) {
      const std::size_t here = reached[i];
      for (const std::size_t index : tree[here]) {
        const MapLink& link = links_[index];
        const std::size_t next = link.a == here ? link.b : link.a;
        if (nodes_[next].root != kNone) continue;
        const Pose2 T_here_next = link.a == here ? link.T_a_b : link.T_a_b.Inverse();
        nodes_[next] = {
            root, here, index, nodes_[here].depth + 1, nodes_[here].T_root_map * T_here_next};
        reached.push_back(next);
      }
    }
  }

  const std::vector<LinkedMap>& maps_;
  const std::vector<MapLink>& links_;
  double span_;
  std::vector<Node> nodes_;
  std::vector<std::size_t> others_;
};

/// Number of edges of all used links that agree.
std::size_t AgreeingEdges(const LinkForest& forest,
                          const std::vector<MapLink>& links,
                          const std::set<std::size_t>& unused) {
  std::size_t edges = 0;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (!unused.contains(i) && forest.Agrees(links[i])) edges += links[i].edges;
  }
  return edges;
}

/// The link to remove, of those on cycles that do not close; kNone when all close.
std::size_t WorstLink(const std::vector<LinkedMap>& maps,
                      const std::vector<MapLink>& links,
                      const std::set<std::size_t>& unused,
                      double span) {
  const LinkForest forest(maps, links, unused, span);
  std::set<std::size_t> suspects;
  for (const std::size_t other : forest.Others()) {
    if (forest.Agrees(links[other])) continue;
    const std::vector<std::size_t> way = forest.Way(links[other]);
    suspects.insert(way.begin(), way.end());
    suspects.insert(other);
  }
  std::size_t worst = kNone;
  std::size_t most = 0;
  for (const std::size_t suspect : suspects) {
    std::set<std::size_t> without = unused;
    without.insert(suspect);
    const LinkForest rest(maps, links, without, span);
    const std::size_t agree = AgreeingEdges(rest, links, without);
    const bool better = worst == kNone || agree > most ||
                        (agree == most && links[suspect].edges < links[worst].edges);
    if (!better) continue;
    worst = suspect;
    most = agree;
  }
  return worst;
}

MapGroup LargestGroup(const LinkForest& forest,
                      const std::vector<LinkedMap>& maps,
                      const std::vector<MapLink>& links,
                      const std::set<std::size_t>& unused) {
  std::vector<std::size_t> keyframes(maps.size(), 0);  // by root
  for (std::size_t map = 0; map < maps.size(); ++map) {
    keyframes[forest.RootOf(map)] += maps[map].keyframes;
  }
  // A map alone is no group as long as any two are joined.
  std::vector<std::size_t> members(maps.size(), 0);
  for (std::size_t map = 0; map < maps.size(); ++map) ++members[forest.RootOf(map)];
  const auto smaller = [&](std::size_t x, std::size_t y) {
    const bool x_alone = members[x] < 2;
    const bool y_alone = members[y] < 2;
    return x_alone != y_alone ? x_alone : keyframes[x] < keyframes[y];
  };
  std::vector<std::size_t> roots(maps.size());
  std::iota(roots.begin(), roots.end(), std::size_t{0});
  const std::size_t root = *std::max_element(roots.begin(), roots.end(), smaller);
  MapGroup group;
  for (std::size_t map = 0; map < maps.size(); ++map) {
    if (forest.RootOf(map) != root) continue;
    group.maps.push_back(map);
    group.T_first_map.push_back(forest.T_root_map(group.maps.front()).Inverse() *
                                forest.T_root_map(map));
  }
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (!unused.contains(i) && forest.RootOf(links[i].a) == root) group.links.push_back(i);
  }
  return group;
}

}  // namespace

LinkChoice ChooseLinks(const std::vector<LinkedMap>& maps,
                       const std::vector<MapLink>& links,
                       const std::vector<std::size_t>& excluded,
                       double span) {
  LinkChoice choice;
  std::set<std::size_t> unused(excluded.begin(), excluded.end());
  for (;;) {
    const std::size_t worst = WorstLink(maps, links, unused, span);
    if (worst == kNone) break;
    unused.insert(worst);
    choice.contradicting.push_back(worst);
  }
  choice.group = LargestGroup(LinkForest(maps, links, unused, span), maps, links, unused);
  return choice;
}

}  // namespace ceilmap::mapping
