#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <random>
#include <stdexcept>

#include "calib/base/pose_with_covariance.hpp"
#include "mapping/graph/keyframe_graph.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::graph {
namespace {

Edge EdgeWithSigma(std::int64_t from, std::int64_t to, const Pose2& T, double sigma) {
  Edge edge{from, to, Edge::Kind::kOdometry, T, {}};
  edge.information = Eigen::Vector3d(1, 1, 4).asDiagonal();
  edge.information /= sigma * sigma;
  return edge;
}

void ExpectSame(const Pose2& a, const Pose2& b) {
  EXPECT_NEAR(a.x, b.x, 1e-12);
  EXPECT_NEAR(a.y, b.y, 1e-12);
  EXPECT_NEAR(WrapAngle(a.yaw - b.yaw), 0, 1e-12);
}

TEST(KeyframeGraph, FindsNeighboursWhereverTheyMove) {
  KeyframeGraph graph(1.0, 0.5);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-20, 20);
  std::vector<Pose2> poses;
  for (std::int64_t id = 0; id < 400; ++id) {
    poses.push_back({place(random), place(random), 0});
    graph.Add(id, poses.back());
  }
  for (std::int64_t id = 0; id < 400; id += 3) {
    poses[static_cast<std::size_t>(id)] = {place(random), place(random), 1};
    graph.Move(id, poses[static_cast<std::size_t>(id)]);
  }
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector2d p(place(random), place(random));
    std::vector<std::int64_t> expected;
    for (std::int64_t id = 0; id < 400; ++id) {
      if ((poses[static_cast<std::size_t>(id)].Translation() - p).norm() <= 3.3) {
        expected.push_back(id);
      }
    }
    EXPECT_EQ(graph.Near(p, 3.3), expected);
  }
}

TEST(KeyframeGraph, ReversedEdgeSaysTheSame) {
  Edge edge = EdgeWithSigma(4, 7, {1.2, -0.4, 2.5}, 0.1);
  edge.information << 9, 1, 2, 1, 8, -1, 2, -1, 30;
  const Edge back = Reversed(edge);
  EXPECT_EQ(back.from, 7);
  EXPECT_EQ(back.to, 4);
  ExpectSame(back.T_from_to * edge.T_from_to, {});
  const Edge again = Reversed(back);
  ExpectSame(again.T_from_to, edge.T_from_to);
  EXPECT_TRUE(again.information.isApprox(edge.information, 1e-12));
  // Forwards and backwards ends at the start, with the spread of both.
  const Eigen::Matrix3d round_trip = ComposeCovariance(
      edge.T_from_to, edge.information.inverse(), back.T_from_to, Eigen::Matrix3d::Zero());
  const Eigen::Matrix3d same = ComposeCovariance(
      edge.T_from_to, Eigen::Matrix3d::Zero(), back.T_from_to, back.information.inverse());
  EXPECT_TRUE(round_trip.isApprox(same, 1e-9)) << round_trip << "\n\n" << same;
}

TEST(KeyframeGraph, FollowsThePathThatIsKnownBest) {
  KeyframeGraph graph(1.0, 0.5);
  for (std::int64_t id = 0; id < 5; ++id) graph.Add(id, {});
  const Pose2 step{1, 0.2, 0.3};
  graph.Add(EdgeWithSigma(0, 1, step, 0.01));
  graph.Add(EdgeWithSigma(2, 1, step.Inverse(), 0.01));  // against the path
  graph.Add(EdgeWithSigma(2, 3, step, 0.01));
  graph.Add(EdgeWithSigma(0, 3, {9, 9, 1}, 0.5));  // short, but bad
  const std::vector<std::int64_t> targets = {3, 4, 0};
  const auto relatives = graph.RelativeTo(0, targets);
  ASSERT_EQ(relatives.size(), 2U) << "nothing leads to keyframe 4";
  ExpectSame(relatives.at(3).T_from_to, step * step * step);
  ExpectSame(relatives.at(0).T_from_to, {});
  EXPECT_EQ(relatives.at(0).covariance, Eigen::Matrix3d::Zero());
  Eigen::Matrix3d expected = Eigen::Matrix3d::Zero();
  Pose2 T;
  const Eigen::Matrix3d of_step = EdgeWithSigma(0, 1, step, 0.01).information.inverse();
  const Eigen::Matrix3d of_reversed =
      Reversed(EdgeWithSigma(2, 1, step.Inverse(), 0.01)).information.inverse();
  for (const Eigen::Matrix3d& covariance : {of_step, of_reversed, of_step}) {
    expected = ComposeCovariance(T, expected, step, covariance);
    T = T * step;
  }
  EXPECT_TRUE(relatives.at(3).covariance.isApprox(expected, 1e-9));
}

TEST(KeyframeGraph, RefusesWhatCannotBe) {
  KeyframeGraph graph(1.0, 0.5);
  graph.Add(2, {});
  EXPECT_TRUE(graph.Has(2));
  EXPECT_FALSE(graph.Has(1));
  EXPECT_THROW(graph.Add(2, {}), std::invalid_argument);
  EXPECT_THROW(graph.Add(-1, {}), std::invalid_argument);
  EXPECT_THROW(graph.Add(EdgeWithSigma(2, 3, {}, 1)), std::invalid_argument);
  EXPECT_THROW(graph.Add(EdgeWithSigma(2, 2, {}, 1)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(graph.T_map_base(1)), std::invalid_argument);
  EXPECT_THROW(KeyframeGraph(0, 1), std::invalid_argument);
}

}  // namespace
}  // namespace ceilmap::graph
