#include "app/evaluation/time_offset.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "app/evaluation/masked_correlation.hpp"
#include "app/evaluation/planar_track.hpp"

namespace ceilmap::evaluation {
namespace {

// A drive that never repeats itself: speed and turns of unequal periods.
Pose2 DriveAt(double t) {
  const double travelled = 0.4 * t - 0.25 * std::cos(0.9 * t) + 0.2 * std::sin(0.37 * t);
  const double yaw = 1.5 * std::sin(0.23 * t) + 0.5 * std::sin(0.71 * t + 1);
  return {travelled * std::cos(0.05 * travelled),
          travelled * std::sin(0.05 * travelled),
          WrapAngle(yaw)};
}

// `first_s` and `last_s` by the clock of the drive; stamps are `offset_s` behind it.
std::vector<StampedPose> Record(
    double first_s, double last_s, double step_s, double offset_s = 0, double noise_m = 0) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const Pose2 T_map_room{3, -2, 2.5};
  std::vector<StampedPose> poses;
  for (double t = first_s; t < last_s; t += step_s) {
    Pose2 pose = DriveAt(t);
    if (noise_m > 0) {
      pose.x += noise_m * normal(random);
      pose.y += noise_m * normal(random);
      pose.yaw += noise_m * normal(random);
      pose = T_map_room * pose;
    }
    poses.push_back(ToStampedPose(t - offset_s, pose));
  }
  return poses;
}

TEST(FindTimeOffset, OfAnotherClockFrameAndRate) {
  const auto offset =
      FindTimeOffset(Record(100, 160, 0.1), Record(100.03, 160, 0.07, 1234.567, 0.005));
  ASSERT_TRUE(offset);
  EXPECT_NEAR(offset->offset_s, 1234.567, 0.005);
  EXPECT_LT(offset->sigma_s, 0.005);
  EXPECT_GT(offset->sigma_s, 1e-5);
  EXPECT_TRUE(offset->IsReliable());
}

TEST(FindTimeOffset, OfSmallOnesAsWell) {
  for (const double expected_s : {0.0, 0.35, -2.6}) {
    const auto offset = FindTimeOffset(Record(0, 60, 0.1), Record(0, 60, 0.1, expected_s, 0.002));
    ASSERT_TRUE(offset);
    EXPECT_NEAR(offset->offset_s, expected_s, 0.004);
    EXPECT_TRUE(offset->IsReliable());
  }
}

TEST(FindTimeOffset, OfAPartOnly) {
  const auto offset = FindTimeOffset(Record(0, 200, 0.1), Record(70, 110, 0.1, -5000, 0.003));
  ASSERT_TRUE(offset);
  EXPECT_NEAR(offset->offset_s, -5000, 0.005);
  EXPECT_TRUE(offset->IsReliable());
}

TEST(FindTimeOffset, GapsAndScaleDoNoHarm) {
  std::vector<StampedPose> estimate = Record(0, 80, 0.1, 40, 0.003);
  estimate.erase(estimate.begin() + 200, estimate.begin() + 350);
  for (StampedPose& pose : estimate) pose.position *= 200;  // pixels
  const auto offset = FindTimeOffset(Record(0, 80, 0.1), estimate);
  ASSERT_TRUE(offset);
  EXPECT_NEAR(offset->offset_s, 40, 0.005);
  EXPECT_TRUE(offset->IsReliable());
}

TEST(FindTimeOffset, ARepetitiveDriveIsNotReliable) {
  const auto laps = [](double first_s, double offset_s) {
    std::vector<StampedPose> poses;
    for (int i = 0; i < 600; ++i) {
      const double t = first_s + 0.1 * i;
      const double angle = t - 0.3 * std::cos(t);  // a lap in 2 pi seconds, faster on one side
      poses.push_back(
          ToStampedPose(t - offset_s, {std::cos(angle), std::sin(angle), WrapAngle(angle)}));
    }
    return poses;
  };
  const auto offset = FindTimeOffset(laps(0, 0), laps(0.05, 300));
  ASSERT_TRUE(offset);
  EXPECT_FALSE(offset->IsReliable());
}

TEST(FindTimeOffset, NothingToGoBy) {
  std::vector<StampedPose> still;
  for (int i = 0; i < 100; ++i) still.push_back(ToStampedPose(i, {1, 2, 0.5}));
  EXPECT_FALSE(FindTimeOffset(still, Delayed(still, 500)));
  EXPECT_FALSE(FindTimeOffset({still[0]}, still));
  EXPECT_FALSE(FindTimeOffset({still[0], still[1]}, {still[0], still[1]}));
}

TEST(FindTimeOffset, OtherDrivesAreNotReliable) {
  const auto offset = FindTimeOffset(Record(0, 60, 0.1), Record(1000, 1060, 0.1, 0, 0.003));
  EXPECT_TRUE(!offset || !offset->IsReliable()) << offset->unexplained;
}

TEST(Delayed, AddsToEachStamp) {
  const auto poses = Delayed({ToStampedPose(1, {1, 0, 0}), ToStampedPose(2, {2, 0, 0})}, -0.5);
  EXPECT_EQ(poses[0].stamp_s, 0.5);
  EXPECT_EQ(poses[1].stamp_s, 1.5);
  EXPECT_EQ(poses[1].position.x(), 2);
}

TEST(PlanarTrack, BetweenPosesButNotInGaps) {
  const PlanarTrack track({ToStampedPose(0, {0, 0, 3}),
                           ToStampedPose(0.5, {1, 2, -3}),
                           ToStampedPose(1, {1, 2, -3}),
                           ToStampedPose(9, {5, 5, 0})});
  EXPECT_EQ(track.MedianStep(), 0.5);
  const auto half = track.At(0.25);
  ASSERT_TRUE(half);
  EXPECT_NEAR((half->position - Eigen::Vector2d(0.5, 1)).norm(), 0, 1e-15);
  EXPECT_NEAR(half->yaw, M_PI, 1e-12);  // along the shorter arc
  EXPECT_TRUE(track.At(0));
  EXPECT_TRUE(track.At(9));
  EXPECT_FALSE(track.At(-0.1));
  EXPECT_FALSE(track.At(9.1));
  EXPECT_FALSE(track.At(5));
}

// Every shift against the sums as they are defined.
TEST(CorrelateShifts, AgreesWithTheDefinition) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(2, 1);
  const auto signal = [&](std::size_t size) {
    MaskedSignal s;
    for (std::size_t i = 0; i < size; ++i) {
      s.known.push_back(i % 5 == 2 ? 0 : 1);
      s.values.push_back(s.known[i] * normal(random));
    }
    return s;
  };
  const MaskedSignal a = signal(23);
  const MaskedSignal b = signal(9);
  const auto agreements = CorrelateShifts(a, b);
  ASSERT_EQ(agreements.size(), 31U);
  for (const ShiftAgreement& agreement : agreements) {
    std::vector<Eigen::Vector2d> both;
    for (std::int64_t k = 0; k < 9; ++k) {
      const std::int64_t i = k + agreement.shift;
      if (i < 0 || i >= 23) continue;
      const auto ia = static_cast<std::size_t>(i);
      const auto ib = static_cast<std::size_t>(k);
      if (a.known[ia] > 0 && b.known[ib] > 0) both.emplace_back(a.values[ia], b.values[ib]);
    }
    const auto n = static_cast<double>(both.size());
    EXPECT_EQ(agreement.overlap, n);
    if (both.size() < 2) continue;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const auto& v : both) mean += v / n;
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
    for (const auto& v : both) covariance += (v - mean) * (v - mean).transpose() / n;
    EXPECT_NEAR(agreement.variance, covariance(0, 0), 1e-9);
    EXPECT_NEAR(agreement.correlation,
                covariance(0, 1) / std::sqrt(covariance(0, 0) * covariance(1, 1)),
                1e-9);
  }
}

}  // namespace
}  // namespace ceilmap::evaluation
