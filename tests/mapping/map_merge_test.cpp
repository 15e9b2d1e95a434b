#include "mapping/map_merge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mapping/common_view.hpp"
#include "tests/mapping/synthetic_drive.hpp"

namespace ceilmap::mapping {
namespace {

using synthetic::CeilingParams;
using synthetic::DriveUnder;
using synthetic::FourArms;
using synthetic::Periodic;
using testing::HasSubstr;

/// A straight drive along x at `y`, from x0 on.
std::vector<Pose2> Row(double x0, double y, int count, double yaw = 0) {
  std::vector<Pose2> places;
  for (int i = 0; i < count; ++i) places.push_back({x0 + 0.7 * i, y, yaw});
  return places;
}

/// Merges drives; the second one's ids begin at 1000.
MergeResult Merge(const DriveUnder& a, const DriveUnder& b) {
  const auto of = [&](std::int64_t id) -> const DriveUnder& { return id < 1000 ? a : b; };
  return MergeGraphs(
      a.view,
      {a.graph, b.graph},
      [&](std::int64_t id) { return of(id).Image(id); },
      [&](std::int64_t id) { return of(id).Descriptors(id); });
}

/// Worst distance of a keyframe from its place to the first one.
double WorstError(const MergeResult& merged, const DriveUnder& a, const DriveUnder& b) {
  double worst = 0;
  const Pose2 T_map_first = merged.graph.keyframes.front().pose.T_map_base;
  for (const graph::Keyframe& keyframe : merged.graph.keyframes) {
    const Pose2& truth = keyframe.id < 1000 ? a.truth.at(keyframe.id) : b.truth.at(keyframe.id);
    const Pose2 expected = T_map_first * a.truth.at(0).Inverse() * truth;
    worst = std::max(worst, (expected.Inverse() * keyframe.pose.T_map_base).Translation().norm());
  }
  return worst;
}

TEST(MapMerge, PartsOfOneCeilingComeTogether) {
  const DriveUnder a({}, Row(0, 0, 9));
  const DriveUnder b({}, Row(2, 0.6, 9, std::numbers::pi), {}, 1000);
  const MergeResult merged = Merge(a, b);
  ASSERT_TRUE(merged.ok()) << merged.results[1].reason;
  EXPECT_EQ(merged.graph.keyframes.size(), 18U);
  EXPECT_EQ(merged.graph.trajectory.size(), 18U);
  EXPECT_LT(WorstError(merged, a, b), 0.03);
  EXPECT_GE(merged.results[1].matched, 3);
  // The first keyframe stays.
  EXPECT_EQ(merged.graph.keyframes.front().pose.T_map_base.x, 0);
}

TEST(MapMerge, KeyframesKeepTheirHeights) {
  DriveUnder a({}, Row(0, 0, 4));
  DriveUnder b({}, Row(0.7, 0.6, 4, std::numbers::pi), {}, 1000);
  // Of the plane that the ceiling is; recognized by the last number.
  const auto heights = [](double scale_sigma) {
    auto field = std::make_shared<heights::HeightField>();
    field->grid = {64, 64};
    field->first_px = {-160, -120};
    field->step_px = {5, 4};
    field->cells.assign(64 * 64, {1, 0.01F});
    field->scale_sigma = scale_sigma;
    return field;
  };
  a.graph.keyframes[1].heights = heights(0.011);
  b.graph.keyframes[2].heights = heights(0.012);
  const MergeResult merged = Merge(a, b);
  ASSERT_TRUE(merged.ok()) << merged.results[1].reason;
  ASSERT_EQ(merged.graph.keyframes.size(), 8U);
  for (const graph::Keyframe& keyframe : merged.graph.keyframes) {
    const bool deep = keyframe.id == 1 || keyframe.id == 1002;
    ASSERT_EQ(keyframe.heights != nullptr, deep) << keyframe.id;
    if (!deep) continue;
    EXPECT_EQ(keyframe.heights->scale_sigma, keyframe.id == 1 ? 0.011 : 0.012);
  }
}

TEST(MapMerge, OtherCeilingsAreRefused) {
  CeilingParams other;
  other.seed = 99;
  const DriveUnder a({}, Row(0, 0, 9));
  const DriveUnder b(other, Row(0, 0, 9), {}, 1000);
  const MergeResult merged = Merge(a, b);
  EXPECT_FALSE(merged.ok());
  EXPECT_EQ(merged.results[1].verdict, JoinResult::Verdict::kNoOverlap);
  EXPECT_THAT(merged.results[1].reason, HasSubstr("no overlap found"));
  EXPECT_EQ(merged.graph.keyframes.size(), 9U) << "what was joined is there";
}

TEST(MapMerge, TooLittleInCommonIsRefused) {
  const DriveUnder a({}, Row(0, 0, 9));
  const DriveUnder b({}, Row(5.6, 0, 9), {}, 1000);  // one place
  const DriveUnder far({}, Row(8.2, 0, 9), {}, 1000);
  EXPECT_FALSE(Merge(a, far).ok());
  const MergeResult little = Merge(a, b);
  if (!little.ok()) {
    EXPECT_THAT(little.results[1].reason, HasSubstr("the overlap is too small"));
  }
}

TEST(MapMerge, PeriodicCeilingIsAmbiguous) {
  const DriveUnder a(Periodic(60), Row(0, 0, 9));
  const DriveUnder b(Periodic(60), Row(3, 0, 9), {}, 1000);
  const MergeResult merged = Merge(a, b);
  EXPECT_FALSE(merged.ok());
  EXPECT_THAT(merged.results[1].reason, HasSubstr("is periodic"));
}

/// Rooms may have the same lamps and signs at the same places: images of both then agree at one
/// position, as in one room, and grooves between equal tiles agree too. Only the grain differs.
registration::synthetic::CeilingParams RoomWithMarks(std::uint32_t seed) {
  registration::synthetic::CeilingParams room = Periodic(70);
  room.seed = seed;
  room.speckle_grey = 10;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> x(-400, 1100);
  std::uniform_real_distribution<double> y(-400, 500);
  for (int i = 0; i < 120; ++i) room.own_marks.emplace_back(x(random), y(random));
  return room;
}

TEST(MapMerge, ARoomThatImitatesAnotherIsAmbiguous) {
  const DriveUnder a(RoomWithMarks(1), Row(0, 0, 9));
  EXPECT_TRUE(Merge(a, DriveUnder(RoomWithMarks(1), Row(0.3, 0.2, 9), {}, 1000)).ok());
  const MergeResult other = Merge(a, DriveUnder(RoomWithMarks(2), Row(0.3, 0.2, 9), {}, 1000));
  EXPECT_FALSE(other.ok());
  EXPECT_THAT(other.results[1].reason, HasSubstr("not as well as neighbours do"));
}

TEST(MapMerge, IdenticalBaysAreAmbiguous) {
  // The same mark every 2 m, seen one or two at a time: every image fits at several places.
  CeilingParams bays = Periodic(0);
  for (int i = -20; i < 40; ++i) {
    bays.own_marks.emplace_back(200.0 * i, 10);
    bays.own_marks.emplace_back(200.0 * i + 50, -60);
    bays.own_marks.emplace_back(200.0 * i + 90, 70);
  }
  const DriveUnder a(bays, Row(0, 0, 14));
  const DriveUnder b(bays, Row(30, 0, 14), {}, 1000);  // elsewhere
  const MergeResult merged = Merge(a, b);
  EXPECT_FALSE(merged.ok()) << "joined where they have nothing in common";
}

TEST(MapMerge, ThirdPartMayHangOnTheSecond) {
  const DriveUnder a({}, Row(0, 0, 8));
  const DriveUnder b({}, Row(3.5, 0.3, 12), {}, 1000);
  const DriveUnder c({}, Row(9.5, 0, 8), {}, 2000);
  const auto of = [&](std::int64_t id) -> const DriveUnder& {
    return id < 1000 ? a : id < 2000 ? b : c;
  };
  const MergeResult merged = MergeGraphs(
      a.view,
      {a.graph, c.graph, b.graph},
      [&](std::int64_t id) { return of(id).Image(id); },
      [&](std::int64_t id) { return of(id).Descriptors(id); });
  ASSERT_TRUE(merged.ok()) << merged.results[1].reason << merged.results[2].reason;
  EXPECT_EQ(merged.graph.keyframes.size(), 28U);
}

/// Headings of a compass on the drive, with another zero direction than the map.
void AddHeadings(DriveUnder& drive, double first_variance) {
  double variance = first_variance;
  for (graph::Keyframe& keyframe : drive.graph.keyframes) {
    variance += 1e-5;
    keyframe.pose.heading = {WrapAngle(drive.truth.at(keyframe.id).yaw + 2), variance};
  }
}

TEST(MapMerge, ACompassResolvesAliasingByAQuarterTurn) {
  const DriveUnder along_x(FourArms(), Row(2, 0, 9));
  std::vector<Pose2> along_y;
  for (const Pose2& T : Row(2, 0, 9)) along_y.push_back(Pose2{0, 0, std::numbers::pi / 2} * T);
  for (const bool compass : {false, true}) {
    DriveUnder a = along_x;
    DriveUnder other_arm(FourArms(), along_y, {}, 1000);
    DriveUnder same_arm(FourArms(), Row(2.3, 0.2, 9, std::numbers::pi / 2), {}, 1000);
    if (compass) {
      AddHeadings(a, 1e-9);
      AddHeadings(other_arm, 0.01);
      AddHeadings(same_arm, 0.01);
    }
    EXPECT_EQ(Merge(a, other_arm).ok(), !compass) << "only the compass resolves it";
    const MergeResult merged = Merge(a, same_arm);
    ASSERT_TRUE(merged.ok()) << merged.results[1].reason;
    EXPECT_LT(WorstError(merged, a, same_arm), 0.03);
  }
}

TEST(MapMerge, RenumberingKeepsWhatBelongsTogether) {
  DriveUnder a({}, Row(0, 0, 4));
  graph::MapGraph graph = a.graph;
  graph.weak_spots.push_back({graph::WeakSpot::Kind::kLost, 2, 0, 0, 1});
  Renumber(graph, 50);
  EXPECT_EQ(graph.keyframes[3].id, 53);
  EXPECT_EQ(graph.keyframes[3].pose.keyframe_id, 53);
  EXPECT_EQ(graph.trajectory[1].keyframe_id, 51);
  EXPECT_EQ(graph.edges[0].from, 50);
  EXPECT_EQ(graph.edges[0].to, 51);
  EXPECT_EQ(graph.weak_spots[0].keyframe_id, 52);
}

// Heights are relative to the distance of the camera from the ceiling.
TEST(Incompatibility, CamerasAtOtherDistancesFromTheCeiling) {
  store::MapMetadata a;
  a.view_size = {640, 480};
  a.view_units_per_px = 0.01;
  store::MapMetadata b = a;
  EXPECT_EQ(Incompatibility(a, b), "");
  a.view_focal_px = 400;
  EXPECT_EQ(Incompatibility(a, b), "") << "an older map does not state it";
  b.view_focal_px = 440;
  EXPECT_EQ(Incompatibility(a, b),
            "their cameras have focal lengths of 400 and 440 px; use maps of one kind of camera at "
            "one height");
}

}  // namespace
}  // namespace ceilmap::mapping
