#include "localization/compass/heading_graph.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "calib/base/pose2.hpp"

namespace ceilmap::compass {
namespace {

using std::numbers::pi;

TEST(HeadingGraph, AddsUpAChain) {
  HeadingGraph graph;
  for (int i = 0; i < 5; ++i) graph.Add(0);
  for (int i = 0; i < 4; ++i) graph.Measure(i, i + 1, 1.0, 0.01);
  graph.Solve();
  EXPECT_NEAR(graph.At(4).heading_rad, 4.0 - 2 * pi, 1e-6);
  EXPECT_NEAR(graph.At(4).variance_rad2, 0.04, 1e-6);
  EXPECT_NEAR(graph.At(0).heading_rad, 0, 1e-12);
  EXPECT_EQ(graph.At(0).variance_rad2, 0);
}

TEST(HeadingGraph, ALoopTakesDriftOut) {
  HeadingGraph graph;
  for (int i = 0; i < 11; ++i) graph.Add(0.61 * i);
  for (int i = 0; i < 10; ++i) graph.Measure(i, i + 1, 0.61, 0.01);  // drifts by 0.01 each
  graph.Solve();
  const double open = graph.At(10).variance_rad2;
  graph.Measure(0, 10, 6.0 - 2 * pi, 1e-6);
  graph.Solve();
  EXPECT_NEAR(graph.At(10).heading_rad, 6.0 - 2 * pi, 1e-4);
  EXPECT_NEAR(WrapAngle(graph.At(5).heading_rad), 3.0, 1e-4);
  EXPECT_LT(graph.At(10).variance_rad2, 0.01 * open);
}

TEST(HeadingGraph, WeighsByVariance) {
  HeadingGraph graph;
  graph.Add(0);
  graph.Add(0);
  graph.Measure(0, 1, 1.0, 0.01);
  graph.Measure(1, 0, -2.0, 0.03);
  graph.Solve();
  EXPECT_NEAR(graph.At(1).heading_rad, 1.25, 1e-6);
  EXPECT_NEAR(graph.At(1).variance_rad2, 0.0075, 1e-6);
}

/// After a place is removed, the information on the others must be the same.
TEST(HeadingGraph, RemovingAPlaceChangesNothingForTheOthers) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 20; ++round) {
    HeadingGraph whole;
    for (int i = 0; i < 9; ++i) whole.Add(0.5 * i);
    for (int i = 0; i < 9; ++i) {
      for (int j = i + 1; j < std::min(9, i + 4); ++j) {
        whole.Measure(i, j, 0.5 * (j - i) + 0.02 * normal(random), 1e-4 * (1 + j - i));
      }
    }
    HeadingGraph part = whole;
    for (const int place : {3, 5, 4}) part.Remove(place);
    EXPECT_EQ(part.Size(), 6);
    whole.Solve();
    part.Solve();
    for (const int i : {1, 2, 6, 7, 8}) {
      EXPECT_NEAR(part.At(i).heading_rad, whole.At(i).heading_rad, 1e-7) << i;
      EXPECT_NEAR(part.At(i).variance_rad2, whole.At(i).variance_rad2, 1e-9) << i;
    }
  }
}

TEST(HeadingGraph, UsesTheNumberOfARemovedPlaceAgain) {
  HeadingGraph graph;
  for (int i = 0; i < 3; ++i) graph.Add(0);
  graph.Measure(0, 1, 0.1, 0.01);
  graph.Measure(1, 2, 0.1, 0.01);
  graph.Remove(1);
  EXPECT_EQ(graph.Add(0.7), 1);
  graph.Measure(2, 1, 0.3, 0.01);
  graph.Solve();
  EXPECT_NEAR(graph.At(1).heading_rad, 0.5, 1e-6);
  EXPECT_THROW(graph.Remove(0), std::invalid_argument);
  EXPECT_THROW(graph.Remove(7), std::invalid_argument);
  EXPECT_THROW(graph.Measure(0, 1, 0, 0), std::invalid_argument);
}

}  // namespace
}  // namespace ceilmap::compass
