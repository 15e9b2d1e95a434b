// Numbers worked out by hand from the definitions that evo publishes (evo/core/metrics.py and
// filters.py).

#include "app/evaluation/relative_errors.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ceilmap::evaluation {
namespace {

PosePair Pair(const Pose2& truth, const Pose2& estimate) {
  return {ToStampedPose(0, truth), ToStampedPose(0, estimate)};
}

// The truth drives three metres straight ahead. The estimate turns left after the first, goes on
// for one metre and then for one and a half.
std::vector<PosePair> Bend() {
  const double left = std::numbers::pi / 2;
  return {Pair({0, 0, 0}, {0, 0, 0}),
          Pair({1, 0, 0}, {1, 0, left}),
          Pair({2, 0, 0}, {1, 1, left}),
          Pair({3, 0, 0}, {1, 2.5, left})};
}

std::vector<PosePair> Line(const std::vector<double>& positions_m) {
  std::vector<PosePair> poses;
  for (const double x : positions_m) poses.push_back(Pair({x, 0, 0}, {x, 0, 0}));
  return poses;
}

TEST(RelativeErrors, PerFrame) {
  // Motions (1, 0) and a turn, (1, 0), (1.5, 0): off by 0, 0, 0.5 m and 90, 0, 0 deg.
  const auto errors = RelativeErrors(Bend(), {.delta = 1, .unit = DeltaUnit::kFrames});
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->translation_m.count, 3);
  EXPECT_NEAR(errors->translation_m.rmse, std::sqrt(0.25 / 3), 1e-12);
  EXPECT_NEAR(errors->translation_m.mean, 0.5 / 3, 1e-12);
  EXPECT_NEAR(errors->rotation_deg.mean, 30, 1e-12);
  EXPECT_NEAR(errors->rotation_deg.rmse, std::sqrt(2700), 1e-12);
  EXPECT_NEAR(errors->rotation_block.max, 2, 1e-12);
  EXPECT_NEAR(errors->full.mean, 2.5 / 3, 1e-12);
}

TEST(RelativeErrors, PerTwoFrames) {
  // From the first to the third: (1, 1) instead of (2, 0). From the second on: 2.5 m instead of 2.
  const auto one = RelativeErrors(Bend(), {.delta = 2, .unit = DeltaUnit::kFrames});
  ASSERT_TRUE(one);
  EXPECT_EQ(one->translation_m.count, 1);
  EXPECT_NEAR(one->translation_m.mean, std::sqrt(2), 1e-12);
  EXPECT_NEAR(one->rotation_deg.mean, 90, 1e-12);
  const auto all =
      RelativeErrors(Bend(), {.delta = 2, .unit = DeltaUnit::kFrames, .all_pairs = true});
  ASSERT_TRUE(all);
  EXPECT_EQ(all->translation_m.count, 2);
  EXPECT_NEAR(all->translation_m.mean, (std::sqrt(2) + 0.5) / 2, 1e-12);
  EXPECT_FALSE(RelativeErrors(Bend(), {.delta = 4, .unit = DeltaUnit::kFrames}));
}

TEST(RelativeErrors, PerMetre) {
  // The first motion begins where a metre is reached for the first time.
  const auto consecutive = RelativeErrors(Bend(), {.delta = 1, .unit = DeltaUnit::kMetres});
  ASSERT_TRUE(consecutive);
  EXPECT_EQ(consecutive->translation_m.count, 2);
  EXPECT_NEAR(consecutive->translation_m.rmse, std::sqrt(0.125), 1e-12);
  EXPECT_NEAR(consecutive->rotation_deg.max, 0, 1e-12);
  // The last motion is half as long again, by its own path.
  const auto all =
      RelativeErrors(Bend(), {.delta = 1, .unit = DeltaUnit::kMetres, .all_pairs = true});
  ASSERT_TRUE(all);
  EXPECT_EQ(all->translation_m.count, 2);
  EXPECT_NEAR(all->translation_m.max, 0, 1e-12);
  EXPECT_NEAR(all->rotation_deg.mean, 45, 1e-12);
}

TEST(SelectPairs, ByThePathOfTheTruth) {
  RelativeParams params{.delta = 1, .unit = DeltaUnit::kMetres, .all_pairs = true};
  EXPECT_EQ(SelectPairs(Bend(), params), (IndexPairs{{0, 1}, {1, 2}}));
  params.path_of_truth = true;
  EXPECT_EQ(SelectPairs(Bend(), params), (IndexPairs{{0, 1}, {1, 2}, {2, 3}}));
}

TEST(SelectPairs, NearestDistanceWithinATenth) {
  RelativeParams params{.delta = 1, .unit = DeltaUnit::kMetres, .all_pairs = true};
  // The robot stands at 1 m: the first pose there counts. From 0.125 m on 1.125 m is a metre away,
  // from 1 m on nothing is.
  EXPECT_EQ(SelectPairs(Line({0, 0.125, 1, 1, 1.125, 1.5}), params), (IndexPairs{{0, 2}, {1, 4}}));
  // Half-way between 0.9375 and 1.0625: the earlier one.
  EXPECT_EQ(SelectPairs(Line({0, 0.9375, 1.0625}), params), (IndexPairs{{0, 1}}));
  EXPECT_EQ(SelectPairs(Line({0, 0.5, 0.75}), params), IndexPairs{});
  EXPECT_EQ(SelectPairs(Line({0}), params), IndexPairs{});
}

TEST(SelectPairs, OneMotionAfterTheOther) {
  const RelativeParams params{.delta = 1, .unit = DeltaUnit::kMetres};
  EXPECT_EQ(SelectPairs(Line({0, 0.5, 1, 1.75, 2.25, 3.25}), params), (IndexPairs{{2, 4}, {4, 5}}));
}

TEST(MeasureSegments, RatioOfTheDistance) {
  // Half-metre steps; the estimate is 2 % long and turns by 0.01 rad a step.
  std::vector<PosePair> poses;
  std::vector<double> distance_m;
  for (int i = 0; i <= 8; ++i) {
    poses.push_back(Pair({0.5 * i, 0, 0}, {0.51 * i, 0, 0}));
    distance_m.push_back(0.5 * i);
  }
  const auto straight = MeasureSegments(poses, distance_m, {.lengths_m = {1, 2, 5}});
  ASSERT_EQ(straight.size(), 2U);  // the path is 4 m long
  EXPECT_EQ(straight[0].length_m, 1);
  EXPECT_EQ(straight[0].translation_percent.count, 7);
  EXPECT_NEAR(straight[0].translation_percent.mean, 2, 1e-12);
  EXPECT_EQ(straight[1].translation_percent.count, 5);
  EXPECT_NEAR(straight[1].translation_percent.max, 2, 1e-12);
  EXPECT_NEAR(straight[1].rotation_deg_per_m.max, 0, 1e-12);
  EXPECT_EQ(MeasureSegments(poses, distance_m, {.lengths_m = {1}, .every = 3})[0]
                .translation_percent.count,
            3);
}

TEST(MeasureSegments, TurnPerMetre) {
  std::vector<PosePair> poses;
  std::vector<double> distance_m;
  for (int i = 0; i <= 8; ++i) {
    poses.push_back(Pair({0.75 * i, 0, 0}, {0.75 * i, 0, 0.015 * i}));
    distance_m.push_back(0.75 * i);
  }
  // Two steps of 0.75 m reach a metre: the error of 1.5 m, per the length that was asked for.
  const auto segments = MeasureSegments(poses, distance_m, {.lengths_m = {1}});
  ASSERT_EQ(segments.size(), 1U);
  EXPECT_NEAR(segments[0].rotation_deg_per_m.max, 0.03 * kDegPerRad, 1e-12);
  // From the first start (1.5, 0) is right; from the i-th it is turned by 0.015 i.
  EXPECT_NEAR(segments[0].translation_percent.min, 0, 1e-12);
  EXPECT_NEAR(segments[0].translation_percent.max, 100 * 1.5 * 2 * std::sin(0.015 * 6 / 2), 1e-10);
}

}  // namespace
}  // namespace ceilmap::evaluation
