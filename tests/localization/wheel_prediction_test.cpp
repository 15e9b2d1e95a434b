#include "localization/wheel_prediction.hpp"

#include <gtest/gtest.h>

namespace ceilmap::localization {
namespace {

wheels::RelativeMotion Ahead(double sigma_m, double sigma_rad = 0) {
  wheels::RelativeMotion step;
  step.T_before_now = {0.5, 0, 0.2};
  step.noise.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
  return step;
}

TEST(WheelPrediction, FollowsTheWheelsFromTheMeasuredPose) {
  WheelPrediction prediction;
  prediction.Move(Ahead(0.1));
  EXPECT_FALSE(prediction.Pose()) << "no pose was measured";
  PoseWithCovariance start{{1, 2, 0.3}};
  start.covariance.diagonal() << 0.02, 0.03, 0.001;
  prediction.Start(start);
  ASSERT_TRUE(prediction.Pose());
  EXPECT_NEAR((prediction.Pose()->covariance - start.covariance).norm(), 0, 1e-12);
  prediction.Move(Ahead(0.1));
  prediction.Move(Ahead(0.1));
  const Pose2 expected = start.pose * Pose2{0.5, 0, 0.2} * Pose2{0.5, 0, 0.2};
  ASSERT_TRUE(prediction.Pose());
  EXPECT_NEAR(prediction.Pose()->pose.x, expected.x, 1e-12);
  EXPECT_NEAR(prediction.Pose()->pose.y, expected.y, 1e-12);
  EXPECT_NEAR(prediction.Pose()->pose.yaw, expected.yaw, 1e-12);
  // The start's yaw error displaces the end too.
  const Eigen::Matrix3d covariance = prediction.Pose()->covariance;
  EXPECT_GT(covariance(0, 0) + covariance(1, 1), 0.05 + 0.04);
  prediction.Start(start);
  EXPECT_NEAR((prediction.Pose()->covariance - start.covariance).norm(), 0, 1e-12);
}

TEST(WheelPrediction, KnowsNothingAfterAnUnknownStep) {
  WheelPrediction prediction;
  prediction.Start({});
  prediction.Move(std::nullopt);
  EXPECT_FALSE(prediction.Pose());
  EXPECT_FALSE(prediction.Motion());
  prediction.Move(Ahead(0.1));
  EXPECT_FALSE(prediction.Pose());
  prediction.Start({});
  EXPECT_TRUE(prediction.Pose());
}

TEST(WheelPrediction, EndsWhereItIsOfNoUse) {
  WheelPrediction prediction;
  prediction.Start({});
  prediction.Move(Ahead(1.2));
  EXPECT_TRUE(prediction.Pose());
  prediction.Move(Ahead(1.2));  // 2.4 m in all
  EXPECT_FALSE(prediction.Pose());
  EXPECT_TRUE(prediction.Motion());
  prediction.Start({});
  prediction.Move(Ahead(0.01, 0.7));
  EXPECT_TRUE(prediction.Pose());
  prediction.Move(Ahead(0.01, 0.7));
  EXPECT_FALSE(prediction.Pose());
}

TEST(WheelPrediction, EndsAfterTenContradictionsInARow) {
  WheelPrediction prediction;
  prediction.Start({});
  for (int i = 0; i < 9; ++i) prediction.Contradict(true);
  EXPECT_TRUE(prediction.Pose());
  prediction.Contradict(false);
  for (int i = 0; i < 9; ++i) prediction.Contradict(true);
  EXPECT_TRUE(prediction.Pose());
  prediction.Contradict(true);
  EXPECT_FALSE(prediction.Pose());
  prediction.Start({});
  for (int i = 0; i < 9; ++i) prediction.Contradict(true);
  EXPECT_TRUE(prediction.Pose()) << "a measured pose forgets them";
}

}  // namespace
}  // namespace ceilmap::localization
