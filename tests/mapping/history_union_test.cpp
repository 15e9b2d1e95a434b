#include "mapping/history_union.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace ceilmap::mapping {
namespace {

graph::Keyframe KeyframeAt(std::int64_t id, const Pose2& T_map_base) {
  graph::Keyframe keyframe;
  keyframe.id = id;
  keyframe.pose.T_map_base = T_map_base;
  return keyframe;
}

store::Change TriangleAt(std::int64_t id, double x, std::int64_t first, std::int64_t last) {
  store::Change change;
  change.id = id;
  change.first_session = first;
  change.last_session = last;
  change.polygons = {{{{x, 0}, {x + 0.3, 0}, {x + 0.3, 1.0 / 3}}}};
  return change;
}

store::MapHistory HistoryOf(const std::vector<std::string>& dates,
                            const std::vector<store::Change>& changes) {
  store::MapHistory history;
  for (const std::string& date : dates) {
    store::Session session;
    session.id = static_cast<std::int64_t>(history.sessions.size()) + 1;
    session.date = date;
    history.sessions.push_back(session);
  }
  history.changes = changes;
  return history;
}

TEST(HistoryUnion, OfOneUnmovedMapIsItsHistoryToTheLastBit) {
  store::MapHistory history =
      HistoryOf({"b", "a"}, {TriangleAt(4, 0.1, 1, 2), TriangleAt(9, 5, 2, 2)});
  history.sessions[0].id = 3;
  history.sessions[1].id = 7;
  const std::vector<graph::Keyframe> keyframes = {KeyframeAt(0, {0.1, 1.0 / 3, 0.7}),
                                                  KeyframeAt(5, {5, 0, 2})};
  graph::MapGraph united;
  united.keyframes = keyframes;
  const store::MapHistory same = UniteHistories({{history, keyframes}}, united);
  ASSERT_EQ(same.sessions.size(), 2U);
  EXPECT_EQ(same.sessions[0].id, 3);
  EXPECT_EQ(same.sessions[1].id, 7);
  ASSERT_EQ(same.changes.size(), 2U);
  EXPECT_EQ(same.changes[1].id, 9);
  EXPECT_EQ(same.changes[0].polygons, history.changes[0].polygons);
}

TEST(HistoryUnion, ChangesMoveWithTheKeyframeNextToThem) {
  const std::vector<graph::Keyframe> before = {KeyframeAt(0, {0, 0, 0}), KeyframeAt(1, {5, 0, 0})};
  graph::MapGraph united;
  united.keyframes = {before[0], KeyframeAt(1, {7, 1, std::numbers::pi / 2})};
  const store::MapHistory moved = UniteHistories(
      {{HistoryOf({"a"}, {TriangleAt(1, 0, 1, 1), TriangleAt(2, 5, 1, 1)}), before}}, united);
  EXPECT_EQ(moved.changes[0].polygons, TriangleAt(1, 0, 1, 1).polygons);
  const cv::Point2d corner = moved.changes[1].polygons[0][0][1];  // 0.3 in front of the keyframe
  EXPECT_NEAR(corner.x, 7, 1e-12);
  EXPECT_NEAR(corner.y, 1.3, 1e-12);
}

TEST(HistoryUnion, SessionsOfTwoMapsAreNumberedByTheirDates) {
  const std::vector<graph::Keyframe> a = {KeyframeAt(0, {0, 0, 0})};
  const std::vector<graph::Keyframe> b = {KeyframeAt(3, {0, 0, 0})};
  graph::MapGraph united;
  united.keyframes = {a[0], b[0]};
  // The second date of b is wrong; its sessions keep their order.
  const store::MapHistory all =
      UniteHistories({{HistoryOf({"2026-02", "2026-04"}, {TriangleAt(1, 0, 1, 2)}), a},
                      {HistoryOf({"2026-03", "2026-01"}, {TriangleAt(1, 0, 2, 2)}), b}},
                     united);
  ASSERT_EQ(all.sessions.size(), 4U);
  const std::vector<std::string> dates = {"2026-02", "2026-03", "2026-01", "2026-04"};
  for (std::size_t i = 0; i < dates.size(); ++i) {
    EXPECT_EQ(all.sessions[i].id, static_cast<std::int64_t>(i) + 1);
    EXPECT_EQ(all.sessions[i].date, dates[i]);
  }
  ASSERT_EQ(all.changes.size(), 2U);
  EXPECT_EQ(all.changes[0].first_session, 1);
  EXPECT_EQ(all.changes[0].last_session, 4);
  EXPECT_EQ(all.changes[1].first_session, 3);
  EXPECT_EQ(all.changes[1].last_session, 3);
  EXPECT_EQ(all.changes[1].id, 2);
}

TEST(HistoryUnion, ChangesOfAMapThatIsNotInTheUnionAreLeftOut) {
  const std::vector<graph::Keyframe> keyframes = {KeyframeAt(0, {0, 0, 0})};
  EXPECT_TRUE(UniteHistories({{HistoryOf({"a"}, {TriangleAt(1, 0, 1, 1)}), keyframes}}, {})
                  .changes.empty());
}

TEST(HistoryUnion, LooksMoveIntoTheTilesOfTheNewMosaic) {
  const std::vector<graph::Keyframe> keyframes = {KeyframeAt(0, {0, 0, 0})};
  store::MosaicGrid before;
  before.min_x = 0;
  before.max_y = 0;
  before.resolution = 0.01;
  before.width_px = 600;
  before.height_px = 600;
  store::MosaicGrid after = before;  // 100 px more to the left, 200 px more at the top
  after.min_x = -1;
  after.max_y = 2;
  after.width_px = 700;
  after.height_px = 800;
  store::Look look;
  look.id = 1;
  look.session = 3;
  look.origin_px = {256, 0};
  look.image = cv::Mat(store::Look::kSizePx, store::Look::kSizePx, CV_8UC1, cv::Scalar(0));
  look.image(cv::Rect(100, 10, 30, 60)).setTo(90);
  const std::vector<store::Look> moved = MoveLooks({look}, {before, keyframes}, {after, keyframes});
  // Columns 356 to 386 become 456 to 486, rows 10 to 70 become 210 to 270: two tiles.
  ASSERT_EQ(moved.size(), 2U);
  EXPECT_EQ(moved[0].origin_px, cv::Point(256, 0));
  EXPECT_EQ(moved[1].origin_px, cv::Point(256, 256));
  EXPECT_EQ(moved[1].id, 2);
  EXPECT_EQ(moved[1].session, 3);
  EXPECT_EQ(cv::countNonZero(moved[0].image), 30 * 46);
  EXPECT_EQ(cv::countNonZero(moved[0].image(cv::Rect(200, 210, 30, 46)) == 90), 30 * 46);
  EXPECT_EQ(cv::countNonZero(moved[1].image(cv::Rect(200, 0, 30, 14)) == 90), 30 * 14);
  EXPECT_EQ(cv::countNonZero(moved[1].image), 30 * 14);
}

}  // namespace
}  // namespace ceilmap::mapping
