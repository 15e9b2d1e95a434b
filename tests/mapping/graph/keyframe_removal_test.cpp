#include "mapping/graph/keyframe_removal.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <set>
#include <tuple>
#include <unordered_map>

#include "calib/base/pose_with_covariance.hpp"
#include "mapping/graph/pose_graph.hpp"
#include "tests/mapping/graph/synthetic_graph.hpp"

namespace ceilmap::graph {
namespace {

Edge WithSigma(std::int64_t from, std::int64_t to, Edge::Kind kind, const Pose2& T, double sigma) {
  Edge edge{from, to, kind, T, {}};
  edge.information = Eigen::Vector3d(1, 1, 4).asDiagonal();
  edge.information /= sigma * sigma;
  return edge;
}

constexpr auto kPath = Edge::Kind::kOdometry;
constexpr auto kClosure = Edge::Kind::kLoopClosure;

TEST(EdgeReduction, AKeyframeOfAPathLeavesTheComposedMotion) {
  const Edge first = WithSigma(3, 5, kPath, {1, 0.2, 0.5}, 0.01);
  const Edge second = WithSigma(9, 5, kPath, {-0.8, 0.1, 2}, 0.02);  // against the path
  EdgeReduction reduction({first, second});
  EXPECT_EQ(reduction.Remove(5), 3);
  const std::vector<Edge> edges = reduction.Edges();
  ASSERT_EQ(edges.size(), 1U);
  EXPECT_EQ(edges[0].from, 3);
  EXPECT_EQ(edges[0].to, 9);
  EXPECT_EQ(edges[0].kind, kPath);
  const Pose2 T = first.T_from_to * second.T_from_to.Inverse();
  EXPECT_NEAR(edges[0].T_from_to.x, T.x, 1e-12);
  EXPECT_NEAR(edges[0].T_from_to.y, T.y, 1e-12);
  EXPECT_NEAR(edges[0].T_from_to.yaw, T.yaw, 1e-12);
  // The marginal covariance of 9 with 3 fixed is that of the graph before.
  std::vector<Pose2> poses(10);
  poses[5] = first.T_from_to;
  poses[9] = T;
  const std::vector<std::int64_t> fixed = {3};
  const Eigen::Matrix3d before = MarginalCovariances(std::vector{first, second}, fixed, poses)[9];
  EXPECT_TRUE(MarginalCovariances(edges, fixed, poses)[9].isApprox(before, 1e-6));
}

TEST(EdgeReduction, TheHeirIsOnThePathAlthoughAClosureIsBetter) {
  EdgeReduction reduction({WithSigma(0, 1, kPath, {1, 0, 0}, 0.05),
                           WithSigma(1, 2, kPath, {1, 0, 0}, 0.03),
                           WithSigma(1, 7, kClosure, {0, 1, 0}, 0.001)});
  EXPECT_EQ(reduction.Remove(1), 2);
  std::set<std::tuple<std::int64_t, std::int64_t, Edge::Kind>> edges;
  for (const Edge& edge : reduction.Edges()) edges.emplace(edge.from, edge.to, edge.kind);
  EXPECT_EQ(edges, (decltype(edges){{2, 0, kPath}, {2, 7, kClosure}}));
}

TEST(EdgeReduction, FusesWithAnEdgeOfTheSameKind) {
  EdgeReduction reduction({WithSigma(0, 1, kPath, {1, 0, 0}, 0.01),
                           WithSigma(1, 2, kClosure, {1, 0, 0}, 0.01),
                           WithSigma(2, 0, kClosure, {-2.1, 0, 0}, 0.01)});
  reduction.Remove(1);
  const std::vector<Edge> edges = reduction.Edges();
  ASSERT_EQ(edges.size(), 1U);
  const Edge forward = edges[0].from == 0 ? edges[0] : Edge{};
  EXPECT_GT(forward.T_from_to.x, 2.01);
  EXPECT_LT(forward.T_from_to.x, 2.09);
  EXPECT_GT(forward.information(0, 0), 1e4);
}

TEST(EdgeReduction, WithoutEdgesNothingIsRemoved) {
  EdgeReduction reduction({WithSigma(0, 1, kPath, {1, 0, 0}, 0.01)});
  EXPECT_FALSE(reduction.Remove(4));
  EXPECT_EQ(reduction.Edges().size(), 1U);
}

/// The graph without two thirds of its keyframes has the optimum and about the certainty of the
/// whole one.
TEST(EdgeReduction, TheRestKeepsItsOptimum) {
  const synthetic::World world = synthetic::Lawnmower(6, 20, 5);
  std::vector<Pose2> whole = world.graph.poses;
  const std::vector<std::int64_t> fixed = {0};
  OptimizePoses(world.graph.edges, fixed, whole);
  std::unordered_map<std::int64_t, Pose2> poses;
  for (std::size_t i = 0; i < whole.size(); ++i) poses[static_cast<std::int64_t>(i)] = whole[i];
  EdgeReduction reduction(world.graph.edges, poses);
  std::vector<std::int64_t> kept;
  for (std::int64_t id = 0; id < static_cast<std::int64_t>(whole.size()); ++id) {
    if (id % 3 == 0) {
      kept.push_back(id);
    } else {
      ASSERT_TRUE(reduction.Remove(id));
    }
  }
  const std::vector<Edge> edges = reduction.Edges();
  EXPECT_LT(edges.size(), world.graph.edges.size() / 2);
  std::set<std::tuple<std::int64_t, std::int64_t, Edge::Kind>> pairs;
  for (const Edge& edge : edges) {
    EXPECT_EQ(edge.from % 3 + edge.to % 3, 0);
    EXPECT_TRUE(pairs.emplace(std::min(edge.from, edge.to), std::max(edge.from, edge.to), edge.kind)
                    .second);
  }
  std::vector<Pose2> reduced = whole;
  ASSERT_TRUE(OptimizePoses(edges, fixed, reduced).converged);
  const auto before = MarginalCovariances(world.graph.edges, fixed, whole);
  const auto after = MarginalCovariances(edges, fixed, reduced);
  for (const std::int64_t id : kept) {
    if (id == 0) continue;
    const auto i = static_cast<std::size_t>(id);
    const double sigma = std::sqrt(before[i](0, 0) + before[i](1, 1));
    EXPECT_LT((reduced[i].Translation() - whole[i].Translation()).norm(), 0.5 * sigma) << id;
    const double ratio = after[i](0, 0) / before[i](0, 0);
    EXPECT_GT(ratio, 0.5) << id;
    EXPECT_LT(ratio, 3) << id;
  }
}

}  // namespace
}  // namespace ceilmap::graph
