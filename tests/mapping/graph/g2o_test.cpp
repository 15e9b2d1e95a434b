#include "mapping/graph/g2o.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <string>
#include <vector>

#include "calib/base/error.hpp"
#include "tests/mapping/graph/synthetic_graph.hpp"

namespace ceilmap::graph {
namespace {

constexpr char kTwo[] = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n";

void ExpectSame(const Pose2& a, const Pose2& b) {
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.yaw, b.yaw);
}

void ExpectSame(const PoseGraph& a, const PoseGraph& b) {
  EXPECT_EQ(a.fixed, b.fixed);
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t i = 0; i < a.poses.size(); ++i) ExpectSame(a.poses[i], b.poses[i]);
  ASSERT_EQ(a.edges.size(), b.edges.size());
  for (std::size_t i = 0; i < a.edges.size(); ++i) {
    EXPECT_EQ(a.edges[i].from, b.edges[i].from);
    EXPECT_EQ(a.edges[i].to, b.edges[i].to);
    EXPECT_EQ(a.edges[i].kind, b.edges[i].kind);
    ExpectSame(a.edges[i].T_from_to, b.edges[i].T_from_to);
    EXPECT_EQ(a.edges[i].information, b.edges[i].information);
  }
}

/// The message that a text is refused with.
std::string Refusal(const std::string& text) {
  try {
    ParseG2o(text, "graph.g2o");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(FormatG2o, ByHand) {
  PoseGraph graph;
  graph.poses = {{0, 0, 0}, {1.5, -2, 0.1}};
  graph.fixed = {0};
  Edge edge;
  edge.to = 1;
  edge.T_from_to = {1, 2, 3};
  edge.information << 4, 0.5, 0.25, 0.5, 5, 0.125, 0.25, 0.125, 6;
  graph.edges = {edge};
  EXPECT_EQ(FormatG2o(graph.poses, graph.edges, graph.fixed),
            "VERTEX_SE2 0 0 0 0\n"
            "VERTEX_SE2 1 1.5 -2 0.1\n"
            "FIX 0\n"
            "EDGE_SE2 0 1 1 2 3 4 0.5 0.25 5 0.125 6\n");
}

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

TEST(FormatG2o, AMapIsWrittenLikeItsPosesAndEdges) {
  const PoseGraph graph = synthetic::Manhattan(60, 5).graph;
  MapGraph map;
  map.edges = graph.edges;
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    Keyframe keyframe;
    keyframe.id = static_cast<std::int64_t>(i);
    keyframe.pose.T_map_base = graph.poses[i];
    keyframe.pose.frame_index = 100 + keyframe.id;  // a vertex is named by its keyframe
    map.keyframes.push_back(keyframe);
    map.trajectory.push_back(keyframe.pose);
  }
  const std::vector<std::int64_t> fixed = {0};
  EXPECT_EQ(FormatG2o(map), FormatG2o(graph.poses, graph.edges, fixed));
}

TEST(ParseG2o, ReadsBackExactlyWhatWasWritten) {
  PoseGraph graph = synthetic::Manhattan(300, 5).graph;
  graph.poses[7] = {1e-300, -1.0 / 3, std::numbers::pi};
  graph.fixed = {0, 299};
  graph.edges[3].information << 2, 1.0 / 3, -0.1, 1.0 / 3, 3, 1e-17, -0.1, 1e-17, 4e9;
  ExpectSame(ParseG2o(FormatG2o(graph.poses, graph.edges, graph.fixed), "graph.g2o"), graph);
  ExpectSame(ParseG2o(FormatG2o({}, {}), "graph.g2o"), PoseGraph());
}

TEST(ParseG2o, AnyOrderBlankLinesCommentsAndLineEnds) {
  const PoseGraph graph = ParseG2o(
      "# a graph\r\n\r\n"
      "EDGE_SE2 1 0 1 2 0.5 1 0 0 1 0 1\r\n"
      "FIX 1\n"
      "  VERTEX_SE2\t1   2 3 7\n"
      "VERTEX_SE2 0 0 0 -0.5",
      "graph.g2o");
  ASSERT_EQ(graph.poses.size(), 2U);
  EXPECT_EQ(graph.poses[0].yaw, -0.5);
  EXPECT_EQ(graph.poses[1].yaw, WrapAngle(7));
  ASSERT_EQ(graph.edges.size(), 1U);
  EXPECT_EQ(graph.edges[0].kind, Edge::Kind::kLoopClosure);
  EXPECT_EQ(graph.fixed, std::vector<std::int64_t>{1});
}

TEST(ParseG2o, RefusesMalformedLines) {
  const std::string two = kTwo;
  const std::string edge = two + "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 ";
  EXPECT_EQ(Refusal(edge + "1"), "accepted");
  EXPECT_EQ(Refusal(edge), "graph.g2o:3: the line ends where a number must stand");
  EXPECT_EQ(Refusal(edge + "1 2"), "graph.g2o:3: '2' is one value too many");
  EXPECT_EQ(Refusal(edge + "1,5"), "graph.g2o:3: '1,5' is not a number");
  EXPECT_EQ(Refusal(edge + "nan"), "graph.g2o:3: numbers must be finite");
  EXPECT_EQ(Refusal(edge + "1e999"), "graph.g2o:3: '1e999' is not a number");
  EXPECT_EQ(Refusal(edge + "-1"), "graph.g2o:3: the information is not positive definite");
  EXPECT_EQ(Refusal("VERTEX_SE2 0.5 0 0 0"), "graph.g2o:1: '0.5' is not a keyframe id");
  EXPECT_EQ(Refusal("\nVERTEX_SE3:QUAT 0 0 0 0 0 0 0 1"),
            "graph.g2o:2: unknown kind 'VERTEX_SE3:QUAT', must be VERTEX_SE2, EDGE_SE2 or FIX");
}

TEST(ParseG2o, RefusesIdsThatDoNotFitTogether) {
  const std::string two = kTwo;
  const std::string numbers = " 1 0 0 1 0 0 1 0 1\n";
  EXPECT_EQ(Refusal(two + "VERTEX_SE2 1 0 0 0"), "graph.g2o:3: there is a VERTEX_SE2 1 already");
  EXPECT_EQ(Refusal(two + "VERTEX_SE2 9000000000 0 0 0"),
            "graph.g2o:3: VERTEX_SE2 9000000000, but no VERTEX_SE2 2; ids must be 0, 1, 2, ...");
  EXPECT_EQ(Refusal(FormatG2o(MapWithGaps())),
            "graph.g2o:1: VERTEX_SE2 4, but no VERTEX_SE2 0; ids must be 0, 1, 2, ...")
      << "gaps are written, and not read";
  EXPECT_EQ(Refusal(two + "VERTEX_SE2 -1 0 0 0"),
            "graph.g2o:3: VERTEX_SE2 -1, but no VERTEX_SE2 0; ids must be 0, 1, 2, ...");
  EXPECT_EQ(Refusal("EDGE_SE2 0 2" + numbers + two), "graph.g2o:1: there is no VERTEX_SE2 2");
  EXPECT_EQ(Refusal(two + "EDGE_SE2 -1 1" + numbers), "graph.g2o:3: there is no VERTEX_SE2 -1");
  EXPECT_EQ(Refusal(two + "EDGE_SE2 1 1" + numbers),
            "graph.g2o:3: the edge leads from a keyframe to itself");
  EXPECT_EQ(Refusal(two + "FIX 5"), "graph.g2o:3: there is no VERTEX_SE2 5");
}

}  // namespace
}  // namespace ceilmap::graph
