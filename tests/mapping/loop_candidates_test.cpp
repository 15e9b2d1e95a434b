#include "mapping/loop_candidates.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "calib/base/error.hpp"
#include "tests/mapping/synthetic_drive.hpp"

namespace ceilmap::mapping {
namespace {

using synthetic::DriveUnder;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;
using testing::ThrowsMessage;

constexpr int kMaxCandidates = 5;

graph::KeyframeGraph GraphOf(const std::vector<Pose2>& poses) {
  graph::KeyframeGraph graph(3.2, 1.6);
  for (std::size_t id = 0; id < poses.size(); ++id) {
    graph.Add(static_cast<std::int64_t>(id), poses[id]);
  }
  return graph;
}

graph::Edge Tie(std::int64_t from, std::int64_t to) {
  return {from, to, graph::Edge::Kind::kOdometry, {}, Eigen::Matrix3d::Identity()};
}

TEST(LoopCandidates, ByPositionMostOverlapFirst) {
  // An image shows 2.4 m along the path and 3.2 m across.
  const calib::CeilingView view = synthetic::SmallView();
  const LoopCandidates candidates(view);
  graph::KeyframeGraph graph =
      GraphOf({{1.2, 0, 0}, {0, 0.3, 0}, {0.6, 0, 0}, {0, 2.3, 0}, {0, 0, 0}});
  EXPECT_THAT(candidates.Find(4, 0.001, graph, kMaxCandidates), ElementsAre(1, 2, 0));
  EXPECT_THAT(candidates.Find(4, 0.3, graph, kMaxCandidates), ElementsAre(1, 2, 0, 3))
      << "it may be nearer than it seems";
  graph.Add(Tie(2, 4));
  EXPECT_THAT(candidates.Find(4, 0.001, graph, kMaxCandidates), ElementsAre(1, 0))
      << "tied already";
}

TEST(LoopCandidates, ByAppearanceWhereThePositionIsNotKnown) {
  const std::vector<Pose2> truth = {{0, 0, 0}, {5, 0, 0}, {10, 0, 0}, {15, 0, 0}, {0.2, 0.1, 0.3}};
  const DriveUnder drive({}, truth);
  LoopCandidatesParams params;
  params.min_keyframe_gap = 2;
  LoopCandidates candidates(drive.view, params);
  LoopCandidates patient(drive.view);
  for (std::int64_t id = 0; id < 5; ++id) {
    candidates.Add(id, drive.Descriptors(id));
    patient.Add(id, drive.Descriptors(id));
  }
  // The graph has it near the last place.
  graph::KeyframeGraph graph = GraphOf({truth[0], truth[1], truth[2], truth[3], truth[3]});
  const std::vector<std::int64_t> retrieved = candidates.Find(4, 1, graph, kMaxCandidates);
  ASSERT_FALSE(retrieved.empty());
  EXPECT_EQ(retrieved.front(), 0);
  EXPECT_THAT(retrieved, Not(Contains(4)));
  EXPECT_EQ(candidates.Find(4, 1, graph, 1).size(), 1U);
  EXPECT_THAT(patient.Find(4, 1, graph, kMaxCandidates), IsEmpty()) << "all of them are recent";
  EXPECT_THAT(candidates.Find(3, 1, graph, kMaxCandidates), IsEmpty()) << "not the latest";
  graph.Add(Tie(0, 4));
  EXPECT_THAT(candidates.Find(4, 1, graph, kMaxCandidates), Not(Contains(0))) << "tied already";
}

TEST(LoopCandidates, RefusesParametersThatCannotBe) {
  LoopCandidatesParams params;
  params.min_keyframe_gap = 0;
  const calib::CeilingView view = synthetic::SmallView();
  EXPECT_THAT([&] { LoopCandidates(view, params); },
              ThrowsMessage<InputError>("loop closing: min_keyframe_gap = 0, must be at least 1"));
}

}  // namespace
}  // namespace ceilmap::mapping
