#include "mapping/keyframe_headings.hpp"

#include <gtest/gtest.h>

#include "calib/base/error.hpp"
#include "mapping/heading_trust.hpp"

namespace ceilmap::mapping {
namespace {

constexpr double kNoise = 0.01;
constexpr double kSingles = 2 * kNoise * kNoise;

TEST(KeyframeHeadings, GiveTurnsInBothDirections) {
  KeyframeHeadings headings;
  headings.Add(3, {0.5, 1e-9});
  headings.Add(4, {1.0, 0.01});
  headings.Add(7, {-3.0, 0.04});
  const auto on = headings.Turn(4, 7);
  ASSERT_TRUE(on);
  EXPECT_NEAR(on->turn_rad, 2 * 3.14159265358979 - 4, 1e-9);
  EXPECT_NEAR(on->variance_rad2, 0.03 + kSingles, 1e-9) << "what it drifted in between";
  const auto back = headings.Turn(7, 4);
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->turn_rad, -on->turn_rad, 1e-12);
  EXPECT_NEAR(back->variance_rad2, on->variance_rad2, 1e-12);
}

TEST(KeyframeHeadings, KnowWhereTheCompassWasBestInBetween) {
  KeyframeHeadings headings;
  headings.Add(0, {0, 1e-9});
  headings.Add(1, {0, 0.04});
  headings.Add(2, {0, 0.01});
  headings.Add(3, {0, 0.04});
  EXPECT_NEAR(headings.Turn(1, 3)->variance_rad2, 0.06 + kSingles, 1e-9);
}

TEST(KeyframeHeadings, KnowNothingOfKeyframesWithoutOne) {
  KeyframeHeadings headings;
  EXPECT_FALSE(headings.Turn(0, 1));
  headings.Add(1, {0, 0.01});
  headings.Add(3, {0, 0.01});
  EXPECT_FALSE(headings.Turn(0, 1));
  EXPECT_FALSE(headings.Turn(1, 2));
  EXPECT_FALSE(headings.Turn(1, 4));
  EXPECT_TRUE(headings.Turn(1, 3));
}

graph::KeyframeGraph::Relative ByGraph(double yaw, double sigma_rad) {
  graph::KeyframeGraph::Relative relative;
  relative.T_from_to = {2, 1, yaw};
  relative.covariance.diagonal() << 0.01, 0.04, sigma_rad * sigma_rad;
  relative.covariance(1, 2) = relative.covariance(2, 1) = 0.1 * sigma_rad;  // an arm: y moves along
  return relative;
}

TEST(KeyframeHeadings, NarrowTheRotationOfTheGraph) {
  KeyframeHeadings headings;
  headings.Add(0, {0, 1e-9});
  headings.Add(1, {1, 2e-9});
  const graph::KeyframeGraph::Relative vague = headings.Narrowed(ByGraph(0.5, 0.5), 0, 1);
  EXPECT_NEAR(vague.T_from_to.yaw, 1, 0.001);
  EXPECT_NEAR(vague.covariance(2, 2), kSingles, 1e-6);
  EXPECT_NEAR(vague.T_from_to.y, 1 + 0.5 * 0.05 / 0.25, 0.001) << "what hangs on it moves along";
  EXPECT_LT(vague.covariance(1, 1), 0.04);
  EXPECT_NEAR(vague.T_from_to.x, 2, 1e-9);
  // The ceiling measures a rotation a hundred times more accurately.
  const graph::KeyframeGraph::Relative exact = headings.Narrowed(ByGraph(0.9, 1e-4), 0, 1);
  EXPECT_NEAR(exact.T_from_to.yaw, 0.9, 1e-5);
}

TEST(KeyframeHeadings, HaveNoWeightAgainstMeasurements) {
  KeyframeHeadings headings;
  headings.Add(0, {0, 1e-9});
  headings.Add(1, {2, 2e-9});
  const graph::KeyframeGraph::Relative kept = headings.Narrowed(ByGraph(0.5, 0.01), 0, 1);
  EXPECT_EQ(kept.T_from_to.yaw, 0.5);
  EXPECT_EQ(kept.covariance, ByGraph(0.5, 0.01).covariance);
  const graph::KeyframeGraph::Relative unknown = headings.Narrowed(ByGraph(0.5, 0.01), 0, 2);
  EXPECT_EQ(unknown.T_from_to.yaw, 0.5);
}

TEST(KeyframeHeadings, DetectEdgesWithAnotherRotation) {
  KeyframeHeadings headings;
  headings.Add(0, {0, 1e-9});
  headings.Add(1, {1, 2e-9});
  graph::Edge edge{0, 1, graph::Edge::Kind::kLoopClosure, {3, 0, 1.1}, {}};
  EXPECT_FALSE(headings.Contradict(edge));
  edge.T_from_to.yaw = 1 + 1.57;
  EXPECT_TRUE(headings.Contradict(edge));
  edge.to = 5;
  EXPECT_FALSE(headings.Contradict(edge)) << "nothing is known there";
}

TEST(HeadingTrust, OnlyAnotherOrientationContradicts) {
  const HeadingTrust trust;
  const HeadingTurn compass{1, 1e-4};
  EXPECT_FALSE(Contradict(compass, {1.2, 0}, trust)) << "20 sigmas, but no quarter turn";
  EXPECT_TRUE(Contradict(compass, {1.3, 0}, trust));
  EXPECT_TRUE(Contradict(compass, {-2.2, 0}, trust));
  EXPECT_FALSE(Contradict(compass, {2.5, 0.1}, trust)) << "the other may be far off";
  EXPECT_FALSE(Contradict({1, 0.1}, {2.5, 0}, trust));
  EXPECT_FALSE(Contradict({3.1, 1e-4}, {-3.1, 0}, trust)) << "over the seam";
}

TEST(HeadingTrust, RefusesImpossibleValues) {
  HeadingTrust trust;
  trust.max_sigmas = 0;
  EXPECT_THROW(trust.Validate(), InputError);
}

}  // namespace
}  // namespace ceilmap::mapping
