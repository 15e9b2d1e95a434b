#include "mapping/map_match.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/base/error.hpp"
#include "tests/mapping/map_files.hpp"

namespace ceilmap::mapping {
namespace {

using synthetic::CeilingParams;
using synthetic::DriveUnder;
using synthetic::MapFiles;

std::vector<Pose2> DriveAlong(double x0, double y, int count, double yaw = 0) {
  std::vector<Pose2> places;
  for (int i = 0; i < count; ++i) places.push_back({x0 + 0.7 * i, y, yaw});
  return places;
}

TEST(MatchMaps, MeasuresEdgesBetweenTheBasesOfTwoCameras) {
  const DriveUnder a({}, DriveAlong(0, 0, 8));
  const DriveUnder b({}, DriveAlong(1.1, 0.5, 8, 2), {}, 0, synthetic::OtherView());
  MapFiles files;
  files.Add("a", a);
  files.Add("b", b);
  const MapMatch match = MatchMaps(files.Maps()[0], files.Maps()[1]);
  ASSERT_TRUE(match.result.ok()) << match.result.reason;
  EXPECT_EQ(match.a.name, "a");
  EXPECT_EQ(match.b.fingerprint, IdentityOf(files.Maps()[1]).fingerprint);
  EXPECT_GE(match.result.edges.size(), 8U);
  EXPECT_GE(match.result.compared, static_cast<int>(match.result.edges.size()));
  for (const graph::Edge& edge : match.result.edges) {
    const Pose2 truth = a.truth.at(edge.from).Inverse() * b.truth.at(edge.to);
    const Pose2 off = edge.T_from_to.Inverse() * truth;
    EXPECT_LT(off.Translation().norm(), 0.004) << edge.from << " -> " << edge.to;
    EXPECT_LT(std::abs(off.yaw), 0.003);
    EXPECT_LT(graph::EdgeChi2(edge, a.truth.at(edge.from), b.truth.at(edge.to)), 60)
        << "the information fits the base at the other end";
  }
  // Both maps begin at their own zero; their odometry has errors of a few millimetres.
  const Pose2 expected = a.truth.at(0).Inverse() * b.truth.at(0);
  EXPECT_LT((expected.Inverse() * match.result.T_a_b).Translation().norm(), 0.02);
}

TEST(MatchMaps, OtherCeilingsAreNotEvenCompared) {
  CeilingParams other;
  other.seed = 99;
  MapFiles files;
  files.Add("a", DriveUnder({}, DriveAlong(0, 0, 8)));
  files.Add("b", DriveUnder(other, DriveAlong(0, 0, 8), {}, 100));
  const MapMatch match = MatchMaps(files.Maps()[0], files.Maps()[1]);
  EXPECT_EQ(match.result.verdict, JoinResult::Verdict::kNoOverlap);
  EXPECT_EQ(match.result.compared, 0);
  EXPECT_THAT(match.result.reason, testing::HasSubstr("no overlap found"));
  EXPECT_TRUE(match.result.edges.empty());
}

TEST(MatchMaps, AMapAndItsCopyAreRefused) {
  const DriveUnder drive({}, DriveAlong(0, 0, 3));
  MapFiles files;
  files.Add("a", drive);
  files.Add("copy", drive);
  EXPECT_THROW(MatchMaps(files.Maps()[0], files.Maps()[1]), InputError);
}

TEST(RelativePose, IsExactForExactEdges) {
  const Pose2 T_a_b{3, -2, 2.5};
  std::vector<graph::Edge> edges(3);
  std::vector<Pose2> T_a_from = {{0, 0, 0.1}, {1, 5, -2}, {-4, 2, 3}};
  std::vector<Pose2> T_b_to = {{2, 1, 0.4}, {0, 3, 1}, {-1, 1, -3}};
  for (std::size_t i = 0; i < edges.size(); ++i) {
    edges[i].T_from_to = T_a_from[i].Inverse() * T_a_b * T_b_to[i];
  }
  for (const std::size_t count : {3, 1}) {
    edges.resize(count);
    const Pose2 off = RelativePose(edges, T_a_from, T_b_to, 2).Inverse() * T_a_b;
    EXPECT_LT(off.Translation().norm(), 1e-12);
    EXPECT_LT(std::abs(off.yaw), 1e-12);
  }
}

}  // namespace
}  // namespace ceilmap::mapping
