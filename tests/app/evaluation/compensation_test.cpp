#include "app/evaluation/compensation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/app/evaluation/debris_drive.hpp"

namespace ceilmap::evaluation {
namespace {

TEST(AlignLevelFrames, TiltedFramesDoNotCount) {
  const LevelAlignment alignment = AlignLevelFrames(Truth(), Estimate(kBefore));
  EXPECT_EQ(alignment.matched, 4);
  EXPECT_EQ(alignment.level, 3);
  ASSERT_TRUE(alignment.T_truth_before);
  EXPECT_NEAR(alignment.T_truth_before->x, kTruthMap.x, 1e-14);
  EXPECT_NEAR(alignment.T_truth_before->y, kTruthMap.y, 1e-14);
  EXPECT_NEAR(alignment.T_truth_before->yaw, kTruthMap.yaw, 1e-14);
}

TEST(AlignLevelFrames, LevelIsBelowTheLimitEitherWay) {
  std::vector<StampedPose> truth = Truth();
  truth[0] = Pose(0, {0, 0, kUp}, {-0.19, 0.19});
  truth[1] = Pose(1, {0, 1, kUp}, {0, -0.21});
  truth[3] = Pose(3, {0, 4, kUp}, {0.21, 0});
  EXPECT_EQ(AlignLevelFrames(truth, Truth()).level, 1);
  EXPECT_EQ(AlignLevelFrames(truth, Truth(), {.level_below_deg = 0.22}).level, 3);
}

TEST(AlignLevelFrames, OneLevelFrameIsNoAnswer) {
  std::vector<StampedPose> before = Estimate(kBefore);
  before.erase(before.begin(), before.begin() + 2);
  const LevelAlignment alignment = AlignLevelFrames(Truth(), before);
  EXPECT_EQ(alignment.matched, 2);
  EXPECT_EQ(alignment.level, 1);
  EXPECT_FALSE(alignment.T_truth_before);
}

TEST(AlignLevelFrames, NothingInCommonIsNoAnswer) {
  const LevelAlignment alignment = AlignLevelFrames(Truth(), {Pose(100, {})});
  EXPECT_EQ(alignment.matched, 0);
  EXPECT_FALSE(alignment.T_truth_before);
}

TEST(CompareCompensation, AlongAndAcrossThePath) {
  const auto result =
      CompareCompensation(Truth(), Estimate(kBefore), Estimate(kAfter, {-3.9, 0.8}), kTruthMap);
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->before.max_along_m, 0.2, 1e-14);
  EXPECT_NEAR(result->before.max_across_m, 0.05, 1e-14);
  EXPECT_NEAR(result->before.max_m, std::sqrt(0.0425), 1e-14);
  EXPECT_NEAR(result->before.rmse_m, std::sqrt(0.0425 / 4), 1e-14);
  EXPECT_NEAR(result->after.max_along_m, 0.02, 1e-14);
  EXPECT_NEAR(result->after.max_across_m, 0.01, 1e-14);
  EXPECT_NEAR(result->ratio.max_along, 0.1, 1e-12);
  EXPECT_NEAR(result->ratio.max_across, 0.2, 1e-12);
  EXPECT_NEAR(result->ratio.max, std::sqrt(5e-4 / 0.0425), 1e-12);
  EXPECT_NEAR(result->ratio.rmse, result->ratio.max, 1e-12);
  EXPECT_NEAR(result->pitch_deg.max, 0.1, 1e-12);
  EXPECT_NEAR(result->pitch_deg.rmse, 0.05, 1e-12);  // one frame of four
  EXPECT_NEAR(result->roll_deg.max, 0.2, 1e-12);
}

// AFTER is of another run, whose map lies elsewhere.
TEST(CompareCompensation, AnotherRunHasAnAlignmentOfItsOwn) {
  const auto same =
      CompareCompensation(Truth(), Estimate(kBefore), Estimate(kAfter, {-3.9, 0.8}), kTruthMap);
  std::vector<StampedPose> elsewhere = Estimate(kAfter, {-3.9, 0.8});
  const Pose2 T_other_map(3, -2, 0.7);
  for (StampedPose& pose : elsewhere) {
    pose.position.head<2>() = T_other_map * Eigen::Vector2d(pose.position.head<2>());
  }
  const auto other = CompareCompensation(
      Truth(), Estimate(kBefore), elsewhere, kTruthMap, {}, kTruthMap * T_other_map.Inverse());
  ASSERT_TRUE(same && other);
  EXPECT_NEAR(other->before.max_along_m, same->before.max_along_m, 1e-14);
  EXPECT_NEAR(other->after.max_along_m, same->after.max_along_m, 1e-12);
  EXPECT_NEAR(other->after.max_across_m, same->after.max_across_m, 1e-12);
  EXPECT_NEAR(other->ratio.max_across, 0.2, 1e-10);
}

TEST(CompareCompensation, SignsOfAFrame) {
  const auto result =
      CompareCompensation(Truth(), Estimate(kBefore), Estimate(kAfter, {-3.9, 0.8}), kTruthMap);
  ASSERT_TRUE(result);
  ASSERT_EQ(result->frames.size(), 4U);
  const CompensatedFrame& frame = result->frames[2];
  EXPECT_EQ(frame.stamp_s, 2);
  EXPECT_NEAR(frame.true_tilt.pitch_deg, -4, 1e-12);
  EXPECT_NEAR(frame.true_tilt.roll_deg, 1, 1e-12);
  ASSERT_TRUE(frame.before && frame.after && frame.tilt);
  EXPECT_NEAR(frame.before->along_m, -0.2, 1e-14);    // behind
  EXPECT_NEAR(frame.before->across_m, -0.05, 1e-14);  // to the right
  EXPECT_NEAR((frame.before->p_truth - Eigen::Vector2d(0.05, 1.8)).norm(), 0, 1e-14);
  EXPECT_NEAR(frame.after->along_m, 0.02, 1e-14);
  EXPECT_NEAR(frame.after->across_m, 0.01, 1e-14);
  EXPECT_NEAR(frame.tilt->pitch_deg, -3.9, 1e-12);
}

TEST(CompareCompensation, MissingFramesAreLeftOut) {
  std::vector<StampedPose> before = Estimate(kBefore);
  std::vector<StampedPose> after = Estimate(kAfter);
  before.erase(before.begin());
  after.pop_back();
  const auto result = CompareCompensation(Truth(), before, after, kTruthMap);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->before.matched, 3);
  EXPECT_EQ(result->before.expected, 4);
  EXPECT_NEAR(result->before.rmse_m, std::sqrt(0.0425 / 3), 1e-14);
  EXPECT_FALSE(result->frames[0].before);
  EXPECT_TRUE(result->frames[0].after);
  EXPECT_FALSE(result->frames[3].after);
  EXPECT_FALSE(result->frames[3].tilt);
}

TEST(CompareCompensation, NothingInCommonIsNoAnswer) {
  EXPECT_FALSE(CompareCompensation(Truth(), Truth(), {Pose(100, {})}, {}));
  EXPECT_FALSE(CompareCompensation(Truth(), {Pose(100, {})}, Truth(), {}));
}

TEST(CompareCompensation, RatioToNoErrorIsANumber) {
  const auto result = CompareCompensation(Truth(), Truth(), Truth(), {});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->before.max_m, 0);
  EXPECT_EQ(result->ratio.max, 0);
  EXPECT_EQ(result->ratio.max_along, 0);
}

TEST(LargestTilt, OfEitherSign) {
  const TiltDegrees largest = LargestTilt(Truth());
  EXPECT_NEAR(largest.pitch_deg, 4, 1e-12);
  EXPECT_NEAR(largest.roll_deg, 1, 1e-12);
}

}  // namespace
}  // namespace ceilmap::evaluation
