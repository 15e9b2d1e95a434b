#include "mapping/change/map_pruning.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "calib/base/error.hpp"
#include "mapping/graph/map_graph.hpp"
#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::change {
namespace {

using store::Change;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr std::int64_t kPerDrive = 12;

/// A drive, repeated: every keyframe is there three more times.
store::synthetic::SmallMap RepeatedDrive() {
  store::synthetic::SmallMap map;
  const std::vector<graph::Keyframe> drive = store::synthetic::Lawnmower(4, 3, 0.1);
  map.keyframes.clear();
  map.edges.clear();
  for (int repetition = 0; repetition < 4; ++repetition) {
    for (graph::Keyframe keyframe : drive) {
      keyframe.id += repetition * kPerDrive;
      keyframe.pose.keyframe_id = keyframe.id;
      keyframe.ambiguous = false;
      keyframe.pose.T_map_base.x += 1e-5 * repetition / 3;
      if (keyframe.id % 5 == 0) keyframe.heights = store::synthetic::Heights(keyframe.id);
      map.keyframes.push_back(keyframe);
    }
  }
  for (std::size_t i = 1; i < map.keyframes.size(); ++i) {
    graph::Edge edge;
    edge.from = map.keyframes[i - 1].id;
    edge.to = map.keyframes[i].id;
    edge.kind = i % kPerDrive == 0 ? graph::Edge::Kind::kLoopClosure : graph::Edge::Kind::kOdometry;
    edge.T_from_to =
        map.keyframes[i - 1].pose.T_map_base.Inverse() * map.keyframes[i].pose.T_map_base;
    edge.information = Eigen::Vector3d(1e6, 1e6, 1e8).asDiagonal();
    map.edges.push_back(edge);
  }
  for (std::size_t i = 0; i < map.trajectory.size(); ++i) {
    map.trajectory[i].keyframe_id = static_cast<std::int64_t>(i);
  }
  return map;
}

Change ChangeIn(std::int64_t id, Change::State state, std::int64_t first, std::int64_t last) {
  Change change;
  change.id = id;
  change.state = state;
  change.first_session = first;
  change.last_session = last;
  change.polygons = {{{{0, 0}, {1, 0}, {1, 1}}}};
  return change;
}

store::MapHistory FiveSessions() {
  store::MapHistory history;
  for (std::int64_t id = 1; id <= 5; ++id) {
    store::Session session;
    session.id = id;
    session.date = "2026-0" + std::to_string(id) + "-15T10:00:00Z";
    history.sessions.push_back(session);
  }
  history.changes = {ChangeIn(1, Change::State::kReplaced, 1, 2),
                     ChangeIn(2, Change::State::kConfirmed, 2, 4),
                     ChangeIn(3, Change::State::kReplaced, 1, 4),
                     ChangeIn(4, Change::State::kCandidate, 3, 3)};
  return history;
}

std::vector<std::int64_t> IdsOf(const std::vector<store::Session>& sessions) {
  std::vector<std::int64_t> ids;
  for (const store::Session& session : sessions) ids.push_back(session.id);
  return ids;
}

TEST(HistorySince, KeepsWhatTheRestRefersTo) {
  const store::MapHistory history = FiveSessions();
  const store::MapHistory kept = HistorySince(history, "2026-04-01");
  ASSERT_EQ(kept.changes.size(), 3U);
  EXPECT_EQ(kept.changes.front().id, 2);
  EXPECT_EQ(IdsOf(kept.sessions), (std::vector<std::int64_t>{1, 2, 3, 4, 5}));
  const store::MapHistory later = HistorySince(history, "2026-12-01");
  EXPECT_EQ(IdsOf(later.sessions), (std::vector<std::int64_t>{2, 3, 4, 5}));
  ASSERT_EQ(later.changes.size(), 2U);
  EXPECT_EQ(HistorySince(history, "2026-01-15").sessions.size(), 5U);
}

TEST(HistorySince, TheLatestSessionAndThoseWithoutADateStay) {
  store::MapHistory history = FiveSessions();
  history.changes.clear();
  history.sessions[1].date.clear();
  EXPECT_EQ(IdsOf(HistorySince(history, "2027-01-01").sessions), (std::vector<std::int64_t>{2, 5}));
}

TEST(PruneOptions, RefusesWhatIsNoDate) {
  PruneOptions options;
  for (const char* date : {"2026-13-01", "2026-1-1", "yesterday", "2026-11-28 10:00:00", ""}) {
    options.before = date;
    EXPECT_THAT([&] { options.Validate(); }, ThrowsMessage<InputError>(HasSubstr("is no date")))
        << date;
  }
  for (const char* date : {"2026-11-28", "2026-11-28T10:00:00Z"}) {
    options.before = date;
    EXPECT_NO_THROW(options.Validate());
  }
}

class PruneMapTest : public testing::Test {
 protected:
  void SetUp() override {
    const store::synthetic::SmallMap map = RepeatedDrive();
    store::MapWriter writer(map_, map.metadata);
    for (const graph::Keyframe& keyframe : map.keyframes) {
      writer.AddDescriptors(keyframe.id, cv::Mat(20, 32, CV_32FC1, cv::Scalar(keyframe.id)));
    }
    map.WriteTo(writer);
    writer.WriteHistory(FiveSessions());
    writer.Commit();
  }

  [[nodiscard]] PruneReport Prune(const PruneOptions& options) const {
    return PruneMap(map_, pruned_, "ceilmap prune", options);
  }

  support::TempFolder folder_;
  std::filesystem::path map_ = folder_ / "m.gpkg";
  std::filesystem::path pruned_ = folder_ / "p.gpkg";
};

TEST_F(PruneMapTest, WhatRemainsStaysToTheLastBit) {
  PruneOptions options;
  options.redundant = true;
  const PruneReport report = Prune(options);
  // Two others show each place: three of four are kept.
  EXPECT_GE(report.keyframes.retired, kPerDrive);
  EXPECT_EQ(report.bytes_after, std::filesystem::file_size(pruned_));
  EXPECT_LT(report.bytes_after, report.bytes_before - 3000 * kPerDrive);
  const store::MapReader before(map_);
  const store::MapReader after(pruned_);
  const graph::MapGraph old = before.ReadGraph();
  const graph::MapGraph graph = after.ReadGraph();
  EXPECT_EQ(std::int64_t(old.keyframes.size() - graph.keyframes.size()), report.keyframes.retired);
  EXPECT_EQ(graph.keyframes.front().id, 0);
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    const graph::Keyframe& same = old.keyframes[static_cast<std::size_t>(keyframe.id)];
    EXPECT_EQ(keyframe.pose.T_map_base.x, same.pose.T_map_base.x);
    EXPECT_EQ(keyframe.pose.T_map_base.y, same.pose.T_map_base.y);
    EXPECT_EQ(keyframe.pose.T_map_base.yaw, same.pose.T_map_base.yaw);
    EXPECT_EQ(keyframe.pose.covariance, same.pose.covariance);
    EXPECT_EQ(keyframe.heights != nullptr, same.heights != nullptr);
    EXPECT_TRUE(
        store::synthetic::Same(after.ReadImage(keyframe.id), before.ReadImage(keyframe.id)));
    EXPECT_EQ(after.ReadDescriptors(keyframe.id).at<float>(0, 0), keyframe.id);
  }
  ASSERT_EQ(graph.trajectory.size(), old.trajectory.size());
  for (std::size_t i = 0; i < graph.trajectory.size(); ++i) {
    EXPECT_EQ(graph.trajectory[i].T_map_base.x, old.trajectory[i].T_map_base.x);
    EXPECT_EQ(graph.trajectory[i].T_map_base.yaw, old.trajectory[i].T_map_base.yaw);
    EXPECT_EQ(graph.trajectory[i].covariance, old.trajectory[i].covariance);
  }
  EXPECT_EQ(graph.weak_spots.size(), old.weak_spots.size());
  EXPECT_EQ(graph::Components(graph).size(), 1U);
  cv::Mat grey[2];
  cv::Mat alpha[2];
  const cv::Rect all(0, 0, before.Grid().width_px, before.Grid().height_px);
  before.ReadMosaic(all, grey[0], alpha[0]);
  after.ReadMosaic(all, grey[1], alpha[1]);
  EXPECT_TRUE(store::synthetic::Same(grey[0], grey[1]));
  EXPECT_TRUE(store::synthetic::Same(alpha[0], alpha[1]));
  EXPECT_EQ(after.ReadHistory().sessions.size(), 5U);
  EXPECT_THAT(after.Metadata().provenance, HasSubstr("ceilmap prune"));
  // Nothing more can be spared.
  EXPECT_EQ(PruneMap(pruned_, pruned_, "again", options).keyframes.retired, 0);
}

TEST_F(PruneMapTest, ABudgetIsKeptWithTheOldestOnesGone) {
  PruneOptions options;
  options.redundant = true;
  const PruneReport smallest = Prune(options);
  options.redundant = false;
  options.max_bytes = (smallest.bytes_before + smallest.bytes_after) / 2;
  const PruneReport report = Prune(options);
  EXPECT_TRUE(report.keyframes.within_budget);
  EXPECT_LE(report.bytes_after, *options.max_bytes);
  EXPECT_GT(report.keyframes.retired, 0);
  EXPECT_LT(report.keyframes.retired, smallest.keyframes.retired);
  options.max_bytes = 1000;
  const PruneReport more = Prune(options);
  EXPECT_FALSE(more.keyframes.within_budget);
  EXPECT_EQ(more.keyframes.retired, smallest.keyframes.retired);
  options.max_bytes = 2 * smallest.bytes_before;
  EXPECT_EQ(Prune(options).keyframes.retired, 0);
}

TEST_F(PruneMapTest, HistoryAloneLeavesKeyframes) {
  PruneOptions options;
  options.before = "2026-12-01";
  const PruneReport report = Prune(options);
  EXPECT_EQ(report.sessions, 1);
  EXPECT_EQ(report.changes, 2);
  EXPECT_EQ(report.keyframes.retired, 0);
  EXPECT_EQ(store::MapReader(pruned_).ReadKeyframes().size(), 4U * kPerDrive);
  EXPECT_EQ(store::MapReader(pruned_).ReadHistory().sessions.size(), 4U);
}

TEST_F(PruneMapTest, AMapInUseByAnotherWriterIsRefused) {
  const store::MapRevision other(map_, map_, "");
  PruneOptions options;
  options.redundant = true;
  EXPECT_THROW(PruneMap(map_, map_, "", options), InputError);
}

}  // namespace
}  // namespace ceilmap::change
