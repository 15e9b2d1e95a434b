#include "mapping/predicted_frames.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace ceilmap::mapping {
namespace {

using graph::FramePose;
using graph::TrackingStatus;

FramePose Frame(std::int64_t index, TrackingStatus status, const Pose2& T_map_base = {}) {
  FramePose frame;
  frame.frame_index = index;
  frame.stamp_s = 0.1 * static_cast<double>(index);
  frame.status = status;
  frame.T_map_base = T_map_base;
  frame.keyframe_id = 7;
  return frame;
}
FramePose Placed(std::int64_t index, const Pose2& T_map_base) {
  return Frame(index, TrackingStatus::kTracking, T_map_base);
}
FramePose Unseen(std::int64_t index) {
  return Frame(index, TrackingStatus::kLost);
}

/// Straight ahead by 0.5 m, with independent errors.
wheels::RelativeMotion Ahead(double sigma_m = 0.03, double sigma_rad = 0.001) {
  wheels::RelativeMotion step;
  step.T_before_now = {0.5, 0, 0};
  step.noise.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
  return step;
}

/// Frames 0 and 4 are placed, 1, 2, 3 show nothing.
PredictedFrames ThreeInTheDark(const wheels::RelativeMotion& step) {
  PredictedFrames frames;
  frames.Interrupt(Placed(0, {}), nullptr);
  for (int i = 1; i <= 3; ++i) frames.Add(Unseen(i), step);
  frames.Interrupt(Placed(4, {}), &step);
  return frames;
}

TEST(PredictedFrames, ARunMeetsBothEnds) {
  // The map sees the end one standard deviation of the wheels further than they do.
  const double sigma_m = 0.03 * std::sqrt(4);
  const std::vector<FramePose> trajectory{Placed(0, {1, 2, 0}), Placed(4, {3 + sigma_m, 2, 0})};
  const std::vector<FramePose> placed = ThreeInTheDark(Ahead()).Place(trajectory);
  ASSERT_EQ(placed.size(), 3U);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const FramePose& frame = placed[i];
    const double share = static_cast<double>(i + 1) / 4;
    EXPECT_EQ(frame.frame_index, static_cast<std::int64_t>(i) + 1);
    EXPECT_EQ(frame.status, TrackingStatus::kPredicted);
    EXPECT_EQ(frame.keyframe_id, 7);
    EXPECT_NEAR(frame.T_map_base.x, 1 + 2 * share + sigma_m * share, 1e-9) << i;
    EXPECT_NEAR(frame.T_map_base.y, 2, 1e-9) << i;
    // A bridge: the variances of both ends in parallel.
    const double variance = sigma_m * sigma_m * share * (1 - share);
    EXPECT_NEAR(frame.covariance(0, 0), variance, 1e-9) << i;
  }
}

// The wheels slip by 0.4 m at an unknown time: before it the frames are where the way from the
// start leads, after it where the way to the end does.
TEST(PredictedFrames, ARunWithASlipCoversBothPredictions) {
  const double slip_m = 0.4;
  const std::vector<FramePose> trajectory{Placed(0, {}), Placed(4, {2 - slip_m, 0, 0})};
  const std::vector<FramePose> placed = ThreeInTheDark(Ahead()).Place(trajectory);
  ASSERT_EQ(placed.size(), 3U);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const double share = static_cast<double>(i + 1) / 4;
    const double before_m = 2 * share;
    const double after_m = before_m - slip_m;
    EXPECT_NEAR(placed[i].T_map_base.x, before_m - slip_m * share, 1e-9) << i;
    const double sigma_m = std::sqrt(placed[i].covariance(0, 0));
    EXPECT_LT(std::abs(placed[i].T_map_base.x - before_m), 2 * sigma_m) << i;
    EXPECT_LT(std::abs(placed[i].T_map_base.x - after_m), 2 * sigma_m) << i;
    EXPECT_LT(std::sqrt(placed[i].covariance(1, 1)), 0.07) << "the robot did not move sideways";
  }
}

TEST(PredictedFrames, ARunGoesTheTurnsOfTheWheels) {
  wheels::RelativeMotion step = Ahead();
  step.T_before_now = {0.5, 0.1, 0.6};
  std::vector<Pose2> truth{{1, 2, 0.5}};
  for (int i = 0; i < 4; ++i) truth.push_back(truth.back() * step.T_before_now);
  const std::vector<FramePose> trajectory{Placed(0, truth[0]), Placed(4, truth[4])};
  const std::vector<FramePose> placed = ThreeInTheDark(step).Place(trajectory);
  ASSERT_EQ(placed.size(), 3U);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    EXPECT_NEAR(placed[i].T_map_base.x, truth[i + 1].x, 1e-9) << i;
    EXPECT_NEAR(placed[i].T_map_base.y, truth[i + 1].y, 1e-9) << i;
    EXPECT_NEAR(WrapAngle(placed[i].T_map_base.yaw - truth[i + 1].yaw), 0, 1e-9) << i;
  }
}

TEST(PredictedFrames, ARunAtTheEndIsPredictedForwards) {
  PredictedFrames frames;
  frames.Interrupt(Placed(0, {}), nullptr);
  for (int i = 1; i <= 3; ++i) frames.Add(Unseen(i), Ahead());
  const std::vector<FramePose> placed = frames.Place({Placed(0, {1, 2, 0})});
  ASSERT_EQ(placed.size(), 3U);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const double steps = static_cast<double>(i) + 1;
    EXPECT_NEAR(placed[i].T_map_base.x, 1 + 0.5 * steps, 1e-12);
    EXPECT_NEAR(placed[i].covariance(0, 0), 0.03 * 0.03 * steps, 1e-12);
  }
}

TEST(PredictedFrames, AnUnknownStepEndsARun) {
  PredictedFrames frames;
  frames.Interrupt(Placed(0, {}), nullptr);
  frames.Add(Unseen(1), Ahead());
  frames.Interrupt(Unseen(2), nullptr);  // the wheels have a gap
  frames.Add(Unseen(3), Ahead());
  const wheels::RelativeMotion step = Ahead();
  frames.Interrupt(Placed(4, {}), &step);
  const std::vector<FramePose> placed =
      frames.Place({Placed(0, {1, 2, 0}), Placed(4, {100, 100, 2})});
  ASSERT_EQ(placed.size(), 1U);
  EXPECT_EQ(placed[0].frame_index, 1);
  EXPECT_NEAR(placed[0].T_map_base.x, 1.5, 1e-12);
  EXPECT_NEAR(placed[0].T_map_base.y, 2, 1e-12);
}

TEST(PredictedFrames, AnUnknownStepToTheEndIsNotUsed) {
  PredictedFrames frames;
  frames.Interrupt(Placed(0, {}), nullptr);
  frames.Add(Unseen(1), Ahead());
  frames.Interrupt(Placed(2, {}), nullptr);
  const std::vector<FramePose> placed = frames.Place({Placed(0, {}), Placed(2, {100, 100, 2})});
  ASSERT_EQ(placed.size(), 1U);
  EXPECT_NEAR(placed[0].T_map_base.x, 0.5, 1e-12);
}

TEST(PredictedFrames, UncertainFramesAreLeftOut) {
  // 1.2 m in x and y after a step, 1.7 m in all; 2 m are exceeded after the second.
  PredictedFrames by_position;
  by_position.Interrupt(Placed(0, {}), nullptr);
  for (int i = 1; i <= 3; ++i) by_position.Add(Unseen(i), Ahead(1.2));
  EXPECT_EQ(by_position.Place({Placed(0, {})}).size(), 1U);
  PredictedFrames by_yaw;
  by_yaw.Interrupt(Placed(0, {}), nullptr);
  for (int i = 1; i <= 3; ++i) by_yaw.Add(Unseen(i), Ahead(0, 0.5));  // 0.7 and 0.87 rad
  EXPECT_EQ(by_yaw.Place({Placed(0, {})}).size(), 2U);
  // Between two ends the same frames are certain enough: 1.7 m in the middle.
  EXPECT_EQ(ThreeInTheDark(Ahead(1.2)).Place({Placed(0, {}), Placed(4, {2, 0, 0})}).size(), 3U);
}

TEST(PredictedFrames, WithoutAPlaceBeforeThereIsNoRun) {
  PredictedFrames frames;
  frames.Add(Unseen(0), Ahead());
  frames.Interrupt(Placed(1, {}), nullptr);
  frames.Interrupt(Placed(2, {}), nullptr);
  EXPECT_TRUE(frames.Place({Placed(1, {}), Placed(2, {})}).empty());
  // The map has left out the segment of the frame before.
  EXPECT_TRUE(ThreeInTheDark(Ahead()).Place({Placed(4, {})}).empty());
}

}  // namespace
}  // namespace ceilmap::mapping
