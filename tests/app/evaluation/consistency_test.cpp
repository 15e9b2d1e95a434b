#include "app/evaluation/consistency.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <random>

namespace ceilmap::evaluation {
namespace {

PoseCovariance Sigmas(double x_m, double y_m, double yaw_rad) {
  return Eigen::Matrix3d(Eigen::Vector3d(x_m * x_m, y_m * y_m, yaw_rad * yaw_rad).asDiagonal());
}

TEST(MeasureConsistency, OfOneFrameByHand) {
  const std::vector<StampedPose> truth = {ToStampedPose(1, {0, 0, 0}), ToStampedPose(2, {5, 0, 0})};
  const std::vector<StampedPose> estimate = {ToStampedPose(1, {0.3, 0.4, 0.02}),
                                             ToStampedPose(2, {5, 0, 0})};
  const auto errors = EvaluateTrajectory(truth, estimate, {.align = Alignment::kNone});
  ASSERT_TRUE(errors);
  // (0.3 / 0.1)^2 + (0.4 / 0.2)^2 = 13; the yaw adds (0.02 / 0.01)^2 = 4. The other frame has no
  // covariance.
  const auto one = MeasureConsistency(*errors, {Sigmas(0.1, 0.2, 0.01), std::nullopt});
  ASSERT_TRUE(one);
  EXPECT_EQ(one->frames, 1);
  EXPECT_NEAR(one->position.mean, 13, 1e-10);
  EXPECT_EQ(one->position.expected, 2);
  EXPECT_EQ(one->position.inside_95, 0);  // beyond 5.99
  EXPECT_NEAR(one->pose.mean, 17, 1e-10);
  EXPECT_EQ(one->pose.expected, 3);
  const auto both = MeasureConsistency(*errors, {Sigmas(0.1, 0.2, 0.01), Sigmas(1, 1, 1)});
  ASSERT_TRUE(both);
  EXPECT_NEAR(both->position.mean, 6.5, 1e-10);
  EXPECT_EQ(both->position.inside_95, 0.5);
}

TEST(MeasureConsistency, CovariancesAreInTheFrameOfTheEstimate) {
  // The map is turned by a quarter: its x is the truth's y. An error of 0.3 m along the map's x is
  // one standard deviation there, and three across. A scale of the alignment counts as well.
  const Pose2 T_map_truth{4, -1, std::numbers::pi / 2};
  std::vector<StampedPose> truth;
  std::vector<StampedPose> estimate;
  for (int i = 0; i < 2; ++i) {
    const Pose2 pose{1.0 * i, 0, 0};
    Pose2 placed = T_map_truth * pose;
    placed.x += i * 0.3;
    truth.push_back(ToStampedPose(i, pose));
    estimate.push_back(ToStampedPose(i, placed));
  }
  const auto errors = EvaluateTrajectory(truth, estimate, {.align = Alignment::kFirst});
  ASSERT_TRUE(errors);
  const auto result = MeasureConsistency(*errors, {std::nullopt, Sigmas(0.3, 0.1, 0.1)});
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->position.mean, 1, 1e-10);
}

TEST(MeasureConsistency, WithoutUsableCovariances) {
  const std::vector<StampedPose> poses = {ToStampedPose(1, {0, 0, 0})};
  const auto errors = EvaluateTrajectory(poses, poses);
  ASSERT_TRUE(errors);
  EXPECT_FALSE(MeasureConsistency(*errors, {std::nullopt}));
  EXPECT_FALSE(MeasureConsistency(*errors, {Sigmas(0, 1, 1)}));
}

TEST(MeasureConsistency, OfErrorsThatAreAsTheySay) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  Eigen::Matrix3d covariance;
  covariance << 4e-4, 1e-4, 0, 1e-4, 1e-4, 2e-5, 0, 2e-5, 1e-4;
  const Eigen::Matrix3d root = covariance.llt().matrixL();
  std::vector<StampedPose> truth;
  std::vector<StampedPose> estimate;
  constexpr int kFrames = 4000;
  for (int i = 0; i < kFrames; ++i) {
    const Eigen::Vector3d e =
        root * Eigen::Vector3d(normal(random), normal(random), normal(random));
    truth.push_back(ToStampedPose(i, {0.1 * i, 0, 1}));
    estimate.push_back(ToStampedPose(i, {0.1 * i + e.x(), e.y(), 1 + e.z()}));
  }
  const auto errors = EvaluateTrajectory(truth, estimate, {.align = Alignment::kNone});
  ASSERT_TRUE(errors);
  const auto result =
      MeasureConsistency(*errors, std::vector<PoseCovariance>(kFrames, PoseCovariance(covariance)));
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->position.mean, 2, 4 * std::sqrt(4.0 / kFrames));  // the variance is 2 n
  EXPECT_NEAR(result->pose.mean, 3, 4 * std::sqrt(6.0 / kFrames));
  EXPECT_NEAR(result->position.median, 2 * std::log(2), 0.15);
  EXPECT_NEAR(result->position.inside_95, 0.95, 0.015);
  EXPECT_NEAR(result->pose.inside_95, 0.95, 0.015);
}

}  // namespace
}  // namespace ceilmap::evaluation
