#include "app/reports/page_parts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::reports {
namespace {

using graph::FramePose;
using graph::TrackingStatus;
using std::numbers::pi;
using testing::ElementsAre;

FramePose Frame(double stamp_s, const Pose2& T_map_base) {
  FramePose frame;
  frame.stamp_s = stamp_s;
  frame.T_map_base = T_map_base;
  frame.covariance = Eigen::Vector3d(1e-6, 4e-6, 9e-6).asDiagonal();
  frame.covariance(0, 1) = frame.covariance(1, 0) = 5e-7;
  return frame;
}

FramePose Unplaced(double stamp_s, TrackingStatus status) {
  FramePose frame = Frame(stamp_s, {1, 2, 3});
  frame.status = status;
  return frame;
}

TEST(PageParts, PosesTakeTheirCovarianceAlong) {
  const page::PagePose pose = ToPagePose(Frame(7, {1, 2, 0.5}));
  EXPECT_EQ(pose.stamp_s, 7);
  EXPECT_EQ(pose.x, 1);
  EXPECT_EQ(pose.y, 2);
  EXPECT_EQ(pose.yaw_rad, 0.5);
  EXPECT_THAT(pose.covariance, ElementsAre(1e-6, 5e-7, 4e-6, 9e-6));
}

TEST(PageParts, FramesWithoutAPlaceHaveNone) {
  for (const TrackingStatus status : {TrackingStatus::kLost, TrackingStatus::kAmbiguous}) {
    const page::PagePose pose = ToPagePose(Unplaced(7, status));
    EXPECT_TRUE(std::isnan(pose.x) && std::isnan(pose.y) && std::isnan(pose.yaw_rad));
    EXPECT_EQ(pose.status, status);
    EXPECT_THAT(pose.covariance, ElementsAre(0, 0, 0, 0));
  }
  EXPECT_EQ(ToPagePose(Unplaced(7, TrackingStatus::kRelocalized)).x, 1);
  const page::PagePose predicted = ToPagePose(Unplaced(7, TrackingStatus::kPredicted));
  EXPECT_EQ(predicted.x, 1);
  EXPECT_THAT(predicted.covariance, ElementsAre(1e-6, 5e-7, 4e-6, 9e-6));
}

TEST(PageParts, FootprintIsTheCamerasViewInBase) {
  // 40 x 20 pixels of 0.1 m, the image's right to the robot's back, half a metre ahead.
  const auto view = calib::CeilingView::OfRectified({40, 20}, 0.1, {0.5, 0, pi});
  const auto corners = FootprintOf(view);
  ASSERT_EQ(corners.size(), 4U);
  const double expected[4][2] = {{2.5, 1}, {-1.5, 1}, {-1.5, -1}, {2.5, -1}};
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(corners[i][0], expected[i][0], 1e-12) << i;
    EXPECT_NEAR(corners[i][1], expected[i][1], 1e-12) << i;
  }
}

TEST(PageParts, ChartsOfARunGoOnBeyondAHalfTurnAndBreakWhereItWasLost) {
  const std::vector<FramePose> frames = {
      Frame(1, {0, 0, 3}), Unplaced(2, TrackingStatus::kLost), Frame(3, {0, 0, -3})};
  const auto charts = ChartsOfRun("run", frames, "m");
  ASSERT_EQ(charts.size(), 3U);  // never tilted
  const page::PageSeries& yaw = charts[0].series.at(0);
  EXPECT_THAT(yaw.x, ElementsAre(1, 2, 3));
  EXPECT_NEAR(yaw.y[0], 3 * 180 / pi, 1e-9);
  EXPECT_TRUE(std::isnan(yaw.y[1]));
  EXPECT_NEAR(yaw.y[2], (2 * pi - 3) * 180 / pi, 1e-9);
  EXPECT_EQ(charts[1].y_label, "sigma (mm)");
  EXPECT_NEAR(charts[1].series[0].y[0], 1e3 * std::sqrt(2.5e-6), 1e-9);
  EXPECT_NEAR(charts[2].series[0].y[0], 0.003 * 180 / pi, 1e-9);
  EXPECT_NEAR(ChartsOfRun("run", frames, "px")[1].series[0].y[0], std::sqrt(2.5e-6), 1e-9);
}

TEST(PageParts, TiltHasAChartWhereThereIsOne) {
  std::vector<FramePose> frames = {Frame(1, {}), Frame(2, {})};
  frames[1].tilt.pitch_rad = 0.01;
  frames[1].tilt.roll_rad = -0.02;
  const auto charts = ChartsOfRun("run", frames, "m");
  ASSERT_EQ(charts.size(), 4U);
  ASSERT_EQ(charts[3].series.size(), 2U);
  EXPECT_NEAR(charts[3].series[0].y[1], 1.8 / pi, 1e-9);
  EXPECT_NEAR(charts[3].series[1].y[1], -3.6 / pi, 1e-9);
}

TEST(PageParts, GraphsBecomeKeyframesEdgesAndSpots) {
  graph::MapGraph graph;
  graph.keyframes.resize(2);
  graph.keyframes[1].id = 5;
  graph.keyframes[1].pose.T_map_base = {1, 2, 0.3};
  graph.edges.resize(2);
  graph.edges[0].to = 5;
  graph.edges[1].from = 5;
  graph.edges[1].kind = graph::Edge::Kind::kLoopClosure;
  graph.weak_spots.push_back({graph::WeakSpot::Kind::kLost, 5, 1, 2, 3});
  page::PageData data;
  AddGraph(graph, "m", data);
  ASSERT_EQ(data.keyframes.size(), 2U);
  EXPECT_EQ(data.keyframes[1].id, 5);
  EXPECT_EQ(data.keyframes[1].yaw_rad, 0.3);
  ASSERT_EQ(data.edges.size(), 2U);
  EXPECT_FALSE(data.edges[0].loop);
  EXPECT_TRUE(data.edges[1].loop);
  ASSERT_EQ(data.spots.size(), 1U);
  EXPECT_THAT(data.spots[0].text, testing::HasSubstr("3 frames could not be placed"));
}

TEST(PageParts, LieInTheBuilding) {
  PageSite site;
  site.frame.S_site_map = {{100, 200, pi / 2}, 2};
  site.frame.sigma_position_m = 0.01;
  const FramePose frame = InSite(site.frame, Frame(7, {1, 2, 0.5}));
  EXPECT_NEAR(frame.T_map_base.x, 96, 1e-12);
  EXPECT_NEAR(frame.T_map_base.y, 202, 1e-12);
  EXPECT_NEAR(frame.T_map_base.yaw, 0.5 + pi / 2, 1e-12);
  EXPECT_NEAR(frame.covariance(0, 0), 4 * 4e-6 + 1e-4, 1e-12);
  const FramePose lost = InSite(site.frame, Unplaced(8, TrackingStatus::kLost));
  EXPECT_EQ(lost.T_map_base.x, 1) << "no pose";

  const support::TestFolder folder;
  store::synthetic::SmallMap().Write(folder / "map.gpkg");
  const store::MapReader map(folder / "map.gpkg");
  page::PageData in_map;
  AddMap(map, {}, in_map);
  site.plan.lines = {{{0, 0}, {1, 1}}};
  page::PageData in_site;
  AddMap(map, site, in_site);
  EXPECT_TRUE(in_map.plan.empty());
  EXPECT_EQ(in_site.plan.lines, site.plan.lines);
  EXPECT_EQ(in_site.S_page_map.motion.x, 100);
  EXPECT_EQ(in_site.picture.min_x, in_map.picture.min_x) << "is placed by the page";
  ASSERT_FALSE(in_map.keyframes.empty());
  EXPECT_NEAR(in_site.keyframes[1].x, 100 - 2 * in_map.keyframes[1].y, 1e-9);
  EXPECT_NEAR(in_site.keyframes[1].y, 200 + 2 * in_map.keyframes[1].x, 1e-9);
  ASSERT_FALSE(in_map.spots.empty());
  EXPECT_NEAR(in_site.spots[0].x, 100 - 2 * in_map.spots[0].y, 1e-9);
  EXPECT_EQ(in_site.spots[0].text, in_map.spots[0].text);
}

}  // namespace
}  // namespace ceilmap::reports
