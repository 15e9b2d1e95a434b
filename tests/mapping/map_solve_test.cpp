#include "mapping/map_solve.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "calib/base/error.hpp"
#include "mapping/graph/fingerprint.hpp"
#include "tests/mapping/map_files.hpp"

namespace ceilmap::mapping {
namespace {

using synthetic::MapFiles;
using synthetic::MetadataOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kSigma = 0.001;

graph::Edge ExactEdge(std::int64_t from, std::int64_t to, const Pose2& T_from_to) {
  graph::Edge edge{from, to, graph::Edge::Kind::kOdometry, T_from_to, {}};
  edge.information = Eigen::Vector3d(1, 1, 4).asDiagonal() * (1 / (kSigma * kSigma));
  return edge;
}

/// Maps of stretches of one corridor along x, with true poses.
class Corridor {
 public:
  /// A map of [x0, x0 + 0.5 count), in a frame of its own.
  void Add(const std::string& name, double x0, int count, double yaw = 0) {
    std::vector<Pose2> truth;
    graph::MapGraph graph;
    for (int i = 0; i < count; ++i) {
      truth.push_back({x0 + 0.5 * i, 0.1 * (i % 3), yaw + 0.2 * (i % 2)});
      graph::Keyframe keyframe;
      keyframe.id = 2 * i;  // ids may have gaps
      keyframe.pose.keyframe_id = keyframe.id;
      keyframe.pose.T_map_base = truth.front().Inverse() * truth.back();
      if (i > 0) {
        graph.edges.push_back(
            ExactEdge(keyframe.id - 2,
                      keyframe.id,
                      truth[static_cast<std::size_t>(i) - 1].Inverse() * truth.back()));
      }
      graph.keyframes.push_back(keyframe);
      graph.trajectory.push_back(keyframe.pose);
    }
    truth_[name] = truth;
    files_.Add(name, MetadataOf(synthetic::SmallView()), graph);
  }

  [[nodiscard]] NamedMap Map(const std::string& name) const {
    for (const NamedMap& map : files_.Maps()) {
      if (map.name == name) return map;
    }
    return {};
  }

  /// Edges between all keyframes at most 0.6 m apart; those of `wrong` have this error.
  [[nodiscard]] NamedMatch Match(const std::string& a,
                                 const std::string& b,
                                 const Pose2& wrong = {}) const {
    NamedMatch named{{IdentityOf(Map(a)), IdentityOf(Map(b)), {}}, a + "-" + b};
    named.match.result.verdict = JoinResult::Verdict::kJoined;
    const std::vector<Pose2>& at_a = truth_.at(a);
    const std::vector<Pose2>& at_b = truth_.at(b);
    for (std::size_t i = 0; i < at_a.size(); ++i) {
      for (std::size_t j = 0; j < at_b.size(); ++j) {
        if ((at_a[i].Translation() - at_b[j].Translation()).norm() > 0.6) continue;
        graph::Edge edge = ExactEdge(2 * static_cast<std::int64_t>(i),
                                     2 * static_cast<std::int64_t>(j),
                                     at_a[i].Inverse() * at_b[j] * wrong);
        edge.kind = graph::Edge::Kind::kLoopClosure;
        named.match.result.edges.push_back(edge);
      }
    }
    return named;
  }
  [[nodiscard]] NamedMatch NoOverlap(const std::string& a, const std::string& b) const {
    NamedMatch named{{IdentityOf(Map(a)), IdentityOf(Map(b)), {}}, a + "-" + b};
    named.match.result.reason = "no overlap found: none of 9 pairs of images agrees";
    return named;
  }

  [[nodiscard]] SolvedMaps Solve(const std::vector<std::string>& names,
                                 const std::vector<NamedMatch>& matches) const {
    std::vector<NamedMap> maps;
    for (const std::string& name : names) maps.push_back(Map(name));
    return SolveMaps(maps, matches);
  }

  /// Largest error of a keyframe relative to the first of the union.
  [[nodiscard]] double Error(const SolvedMaps& solved,
                             const std::vector<std::string>& names) const {
    const auto truth = [&](std::int64_t id) {
      std::size_t map = names.size() - 1;
      while (solved.first_ids[map] > id) --map;
      return truth_.at(names[map])[static_cast<std::size_t>(id - solved.first_ids[map]) / 2];
    };
    double worst = 0;
    const graph::Keyframe& first = solved.graph.keyframes.front();
    for (const graph::Keyframe& keyframe : solved.graph.keyframes) {
      const Pose2 expected = first.pose.T_map_base * truth(first.id).Inverse() * truth(keyframe.id);
      const Pose2 off = expected.Inverse() * keyframe.pose.T_map_base;
      worst = std::max({worst, off.Translation().norm(), std::abs(off.yaw)});
    }
    return worst;
  }

 private:
  MapFiles files_;
  std::map<std::string, std::vector<Pose2>> truth_;
};

std::string RefusalOf(const Corridor& world,
                      const std::vector<std::string>& names,
                      const std::vector<NamedMatch>& matches) {
  try {
    static_cast<void>(world.Solve(names, matches));
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(SolveMaps, PutsMapsInTheFrameOfTheFirstOne) {
  Corridor world;
  world.Add("a", 0, 12, 0.3);
  world.Add("b", 4, 12, 2);
  world.Add("c", 8, 12, -1);
  const SolvedMaps solved =
      world.Solve({"b", "a", "c"}, {world.Match("a", "b"), world.Match("c", "b")});
  EXPECT_THAT(solved.joined, ElementsAre(0, 1, 2));
  EXPECT_THAT(solved.left_out, IsEmpty());
  EXPECT_EQ(solved.graph.keyframes.size(), 36U);
  EXPECT_EQ(solved.graph.trajectory.size(), 36U);
  EXPECT_LT(world.Error(solved, {"b", "a", "c"}), 1e-6);
  const Pose2& first = solved.graph.keyframes.front().pose.T_map_base;
  EXPECT_NEAR(first.Translation().norm() + std::abs(first.yaw), 0, 1e-12);
  EXPECT_GT(solved.graph.quality.loops.accepted, 20);
  EXPECT_EQ(solved.graph.quality.loops.outliers, 0);
}

// In either direction of the matches; a single step of the optimization would not mend a bad start.
TEST(SolveMaps, StartsAtThePosesThatTheMatchesGive) {
  Corridor world;
  world.Add("a", 0, 12, 0.3);
  world.Add("b", 4, 12, 2);
  world.Add("c", 8, 12, -1);
  for (const bool turned : {false, true}) {
    const SolvedMaps solved = SolveMaps({world.Map("a"), world.Map("b"), world.Map("c")},
                                        {turned ? world.Match("b", "a") : world.Match("a", "b"),
                                         turned ? world.Match("c", "b") : world.Match("b", "c")},
                                        {.max_iterations = 1});
    EXPECT_THAT(solved.joined, ElementsAre(0, 1, 2)) << turned;
    EXPECT_THAT(solved.contradictions, IsEmpty()) << turned;
    EXPECT_LT(world.Error(solved, {"a", "b", "c"}), 1e-9) << turned;
  }
}

TEST(SolveMaps, StrangersAreLeftOutWithTheReason) {
  Corridor world;
  world.Add("a", 0, 12);
  world.Add("b", 4, 12);
  world.Add("stranger", 50, 30);
  world.Add("x", 90, 4);
  world.Add("y", 90.5, 5);
  const SolvedMaps solved = world.Solve({"stranger", "a", "x", "b", "y"},
                                        {world.Match("a", "b"),
                                         world.NoOverlap("a", "stranger"),
                                         world.NoOverlap("stranger", "b"),
                                         world.Match("x", "y")});
  EXPECT_THAT(solved.joined, ElementsAre(1, 3)) << "not the large one that is alone";
  ASSERT_EQ(solved.left_out.size(), 3U);
  EXPECT_EQ(solved.left_out[0].map, 0U);
  EXPECT_EQ(solved.left_out[0].reason, "it has no sufficient overlap with any of 2 maps");
  EXPECT_EQ(solved.left_out[1].reason, "it joins only y, which do not join the rest");
  const SolvedMaps unnamed = world.Solve({"a", "b", "x"}, {world.Match("a", "b")});
  EXPECT_THAT(unnamed.left_out.at(0).reason, HasSubstr("no edges file is about it"));
}

TEST(SolveMaps, WithoutAPairThereIsNoUnion) {
  Corridor world;
  world.Add("a", 0, 12);
  world.Add("b", 40, 13);
  const SolvedMaps solved = world.Solve({"a", "b"}, {world.NoOverlap("a", "b")});
  EXPECT_THAT(solved.joined, IsEmpty());
  ASSERT_EQ(solved.left_out.size(), 2U);
  EXPECT_THAT(solved.left_out[1].reason, HasSubstr("none of 9 pairs of images agrees"));
}

// Whether large or as small as a tile, a wrong relative pose must not bend the map.
TEST(SolveMaps, AContradictionIsNamedAndBendsNothing) {
  Corridor world;
  world.Add("a", 0, 14, 0.3);
  world.Add("b", 3, 14, 2);
  world.Add("c", 5, 14, -1);
  for (const double error : {9.0, 0.6}) {
    const SolvedMaps solved = world.Solve(
        {"a", "b", "c"},
        {world.Match("a", "b"), world.Match("a", "c", {error, 0, 0}), world.Match("b", "c")});
    EXPECT_THAT(solved.joined, ElementsAre(0, 1, 2));
    ASSERT_EQ(solved.contradictions.size(), 1U) << error;
    const auto& pair = solved.contradictions.front();
    EXPECT_EQ(std::min(pair.a, pair.b), 0U);
    EXPECT_EQ(std::max(pair.a, pair.b), 2U);
    EXPECT_THAT(pair.reason, HasSubstr("they contradict"));
    EXPECT_LT(world.Error(solved, {"a", "b", "c"}), 1e-5);
  }
}

TEST(SolveMaps, OrderMakesNoDifferenceToWhatIsJoined) {
  Corridor world;
  std::vector<std::string> names = {"a", "b", "c", "d", "stranger"};
  world.Add("a", 0, 14, 0.3);
  world.Add("b", 3, 14, 2);
  world.Add("c", 5, 14, -1);
  world.Add("d", 9, 14, 3);
  world.Add("stranger", 50, 14);
  // Two wrong pairs of as many edges as right ones.
  std::vector<NamedMatch> matches = {world.Match("a", "b"),
                                     world.Match("c", "b"),
                                     world.Match("a", "c", {7, 0, 0}),
                                     world.Match("d", "c"),
                                     world.Match("b", "d", {0.6, 0, 0}),
                                     world.NoOverlap("stranger", "a")};
  std::map<std::string, int> outcomes;
  std::sort(names.begin(), names.end());
  for (int turn = 0; turn < 5; ++turn) {
    std::rotate(names.begin(), names.begin() + 1, names.end());
    std::rotate(matches.begin(), matches.begin() + 2, matches.end());
    if (turn % 2 == 1) std::swap(names[0], names[3]);
    const SolvedMaps solved = world.Solve(names, matches);
    std::vector<std::string> joined;
    for (const std::size_t map : solved.joined) joined.push_back(names[map]);
    std::sort(joined.begin(), joined.end());
    std::vector<std::string> pairs;
    for (const auto& pair : solved.contradictions) {
      const auto [x, y] = std::minmax(names[pair.a], names[pair.b]);
      pairs.push_back(x + y);
    }
    std::sort(pairs.begin(), pairs.end());
    std::string outcome;
    for (const std::string& name : joined) outcome += name + " ";
    for (const std::string& pair : pairs) outcome += "!" + pair;
    ++outcomes[outcome];
    EXPECT_LT(world.Error(solved, names), 1e-5) << outcome;
  }
  EXPECT_THAT(outcomes, ElementsAre(testing::Pair("a b c d !ac!bd", 5)));
}

TEST(SolveMaps, MatchesOfOtherMapsAreRefused) {
  Corridor world;
  world.Add("a", 0, 12);
  world.Add("b", 4, 12);
  world.Add("c", 8, 13);
  NamedMatch match = world.Match("a", "b");
  EXPECT_EQ(
      RefusalOf(world, {"a", "c"}, {match}),
      "a-b: is about b, which is not among the maps; give this map too, leave the file out, or "
      "run 'ceilmap match' again");
  EXPECT_EQ(RefusalOf(world, {"a", "b"}, {match, world.Match("b", "a")}),
            "a-b and b-a are about the same two maps; give one of them");
  EXPECT_EQ(RefusalOf(world, {"a", "b", "a"}, {match}), "a and a are the same map; give it once");
  NamedMatch foreign = match;
  foreign.match.result.edges[0].to = 1;
  EXPECT_EQ(RefusalOf(world, {"a", "b"}, {foreign}),
            "a-b: has an edge of a keyframe that a or b does not have; run 'ceilmap match' again");
  match.match.b.fingerprint += 1;
  EXPECT_EQ(RefusalOf(world, {"a", "b"}, {match}),
            "a-b: was made of another version of b; run 'ceilmap match' again");
}

}  // namespace
}  // namespace ceilmap::mapping
