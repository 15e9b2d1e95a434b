#include "mapping/graph/g2o.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace ceilmap::graph {
namespace {

/// Three keyframes left of many, as in a part that is cut out of a map.
MapGraph MapWithGaps() {
  MapGraph graph;
  graph.keyframes.resize(3);
  graph.keyframes[0].id = 4;
  graph.keyframes[0].pose.T_map_base = {0.5, -0.25, 3};
  graph.keyframes[1].id = 7;
  graph.keyframes[1].pose.T_map_base = {1.5, -2, 0.1};
  graph.keyframes[2].id = 12;
  graph.keyframes[2].pose.T_map_base = {-3, 1e-7, -0.5};
  Edge tie{4, 7, Edge::Kind::kOdometry, {1, 2, 3}, {}};
  tie.information << 4, 0.5, 0.25, 0.5, 5, 0.125, 0.25, 0.125, 6;
  Edge loop{12, 4, Edge::Kind::kLoopClosure, {-1, -2, -3}, {}};
  loop.information << 7, 1.5, 2.5, 1.5, 8, 3.5, 2.5, 3.5, 9;
  graph.edges = {tie, loop};
  return graph;
}

TEST(FormatG2o, AMapKeepsItsIdsAndFixesTheFirstKeyframe) {
  EXPECT_EQ(FormatG2o(MapWithGaps()),
            "VERTEX_SE2 4 0.5 -0.25 3\n"
            "VERTEX_SE2 7 1.5 -2 0.1\n"
            "VERTEX_SE2 12 -3 1e-07 -0.5\n"
            "FIX 4\n"
            "EDGE_SE2 4 7 1 2 3 4 0.5 0.25 5 0.125 6\n"
            "EDGE_SE2 12 4 -1 -2 -3 7 1.5 2.5 8 3.5 9\n");
  EXPECT_EQ(FormatG2o(MapGraph()), "") << "nothing to fix";
}

// Each number reads back as the same value.
TEST(FormatG2o, NumbersAreExact) {
  MapGraph graph;
  graph.keyframes.resize(1);
  graph.keyframes[0].pose.T_map_base = {1e-300, -1.0 / 3, std::numbers::pi};
  EXPECT_EQ(FormatG2o(graph), "VERTEX_SE2 0 1e-300 -0.3333333333333333 3.141592653589793\nFIX 0\n");
}

}  // namespace
}  // namespace ceilmap::graph
