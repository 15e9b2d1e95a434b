#include "app/evaluation/heading_errors.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calib/base/pose2.hpp"

namespace ceilmap::evaluation {
namespace {

StampedPose True(double stamp_s, double x_m, double yaw_deg) {
  return ToStampedPose(stamp_s, {x_m, 0, WrapAngle(yaw_deg * kRadPerDeg)});
}

StampedHeading Measured(double stamp_s, double heading_deg) {
  return {stamp_s, WrapAngle(heading_deg * kRadPerDeg)};
}

// Three full turns over 10 m, a compass that gains 0.2 degrees per metre and starts at the second
// true pose.
TEST(CompareHeadings, DriftAndEndOverFullTurns) {
  std::vector<StampedPose> truth;
  std::vector<StampedHeading> headings;
  for (int i = 0; i <= 100; ++i) {
    truth.push_back(True(5 + 0.5 * i, 0.1 * i, 100 + 10.8 * i));
    if (i > 0) headings.push_back(Measured(5.004 + 0.5 * i, (10.8 + 0.02) * (i - 1)));
  }
  const auto errors = CompareHeadings(headings, truth, 0.02);
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->of.size(), 100U);
  EXPECT_NEAR(errors->coverage, 100.0 / 101, 1e-12);
  EXPECT_NEAR(errors->path_m, 9.9, 1e-9);
  EXPECT_NEAR(errors->seconds, 49.5, 1e-9);
  EXPECT_NEAR(errors->turned_deg, 99 * 10.8, 1e-6);
  EXPECT_NEAR(errors->of[99].true_deg, 99 * 10.8, 1e-6);
  EXPECT_NEAR(errors->of[99].error_deg, 1.98, 1e-6);
  EXPECT_NEAR(errors->error_deg.max, 1.98, 1e-6);
  EXPECT_NEAR(errors->end_deg, 1.98, 1e-6);
  EXPECT_NEAR(errors->signed_mean_deg, 0.99, 1e-6);
  EXPECT_NEAR(errors->std_deg, 0.02 * std::sqrt((100.0 * 100 - 1) / 12), 1e-6);
  EXPECT_NEAR(errors->drift_deg_per_m.value(), 0.2, 1e-6);
  EXPECT_NEAR(errors->drift_deg_per_s.value(), 0.04, 1e-6);
}

// An error that grows past half a turn does not come back as a small one.
TEST(CompareHeadings, ErrorsGoOnBeyondHalfATurn) {
  std::vector<StampedPose> truth;
  std::vector<StampedHeading> headings;
  for (int i = 0; i <= 30; ++i) {
    truth.push_back(True(i, 0, 0));
    headings.push_back(Measured(i, 10 * i));
  }
  const auto errors = CompareHeadings(headings, truth, 0.02);
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->end_deg, 300, 1e-6);
  EXPECT_FALSE(errors->drift_deg_per_m);  // it did not travel
}

TEST(CompareHeadings, OfATrajectoryInAnotherFrame) {
  std::vector<StampedPose> truth;
  std::vector<StampedPose> estimate;
  for (int i = 0; i <= 10; ++i) {
    truth.push_back(True(i, 0.2 * i, 170 + 5 * i));
    estimate.push_back(True(i, 0, -40 + 5.1 * i));
  }
  const auto errors = CompareHeadings(HeadingsOf(estimate), truth, 0.02);
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->end_deg, 1, 1e-9);
  EXPECT_NEAR(errors->drift_deg_per_m.value(), 0.5, 1e-9);
  EXPECT_NEAR(errors->drift_deg_per_s.value(), 0.1, 1e-9);
}

// An absolute compass that is wrong from the first frame on, and once by more than half a turn.
TEST(CompareHeadings, OfAnAbsoluteCompass) {
  std::vector<StampedPose> truth;
  std::vector<StampedHeading> headings;
  for (int i = 0; i <= 40; ++i) {
    truth.push_back(True(i, 0, 170 + 10 * i));
    headings.push_back(Measured(i, 170 + 10 * i + (i == 7 ? 190 : 3)));
  }
  const auto errors = CompareHeadings(headings, truth, 0.02, HeadingZero::kTruth);
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->of.front().error_deg, 3, 1e-6);
  EXPECT_NEAR(errors->of[7].error_deg, -170, 1e-6);
  EXPECT_NEAR(errors->of.back().error_deg, 3, 1e-6);
  EXPECT_NEAR(errors->of.back().true_deg, 570, 1e-6);
  EXPECT_NEAR(errors->error_deg.max, 170, 1e-6);
  EXPECT_NEAR(errors->error_deg.median, 3, 1e-6);
}

TEST(CompareHeadings, OfOneMomentOrNone) {
  const auto one = CompareHeadings({Measured(1, 40)}, {True(1, 0, 7), True(2, 1, 9)}, 0.02);
  ASSERT_TRUE(one);
  EXPECT_EQ(one->end_deg, 0);
  EXPECT_FALSE(one->drift_deg_per_s);
  EXPECT_FALSE(CompareHeadings({Measured(1.1, 40)}, {True(1, 0, 7)}, 0.02));
}

}  // namespace
}  // namespace ceilmap::evaluation
