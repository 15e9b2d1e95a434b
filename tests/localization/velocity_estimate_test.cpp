#include "localization/velocity_estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ceilmap::localization {
namespace {

constexpr double kDurationS = 0.04;
const Twist2 kVelocity{{2.5, 0.1}, 1.2};

Eigen::Matrix3d Exact() {
  return 1e-8 * Eigen::Matrix3d::Identity();
}

TEST(VelocityEstimate, IsThatOfAMeasuredStep) {
  VelocityEstimate estimate;
  EXPECT_FALSE(estimate.IsKnown());
  estimate.Take(kVelocity.Over(kDurationS), Exact(), kDurationS);
  ASSERT_TRUE(estimate.IsKnown());
  EXPECT_NEAR(estimate.Velocity()->linear_m_s.x(), 2.5, 1e-9);
  EXPECT_NEAR(estimate.Velocity()->yaw_rad_s, 1.2, 1e-9);
  const PoseWithCovariance next = estimate.MoveOn(2 * kDurationS);
  const Pose2 expected = kVelocity.Over(2 * kDurationS);
  EXPECT_NEAR(next.pose.x, expected.x, 1e-9);
  EXPECT_NEAR(next.pose.y, expected.y, 1e-9);
  EXPECT_NEAR(next.pose.yaw, expected.yaw, 1e-9);
  estimate.Forget();
  EXPECT_FALSE(estimate.IsKnown());
}

TEST(VelocityEstimate, HardlyFollowsABadlyMeasuredStep) {
  VelocityEstimate estimate;
  for (int i = 0; i < 5; ++i) estimate.Take(kVelocity.Over(kDurationS), Exact(), kDurationS);
  const Pose2 wrong = kVelocity.Over(kDurationS) * Pose2{0.04, -0.06, 0};
  constexpr double kSigma = 0.05;
  estimate.Take(wrong, kSigma * kSigma * Eigen::Matrix3d::Identity(), kDurationS);
  const PoseWithCovariance next = estimate.MoveOn(kDurationS);
  EXPECT_NEAR(next.pose.x, kVelocity.Over(kDurationS).x, 0.005);
  EXPECT_NEAR(next.pose.y, kVelocity.Over(kDurationS).y, 0.005);
}

TEST(VelocityEstimate, BecomesLessCertainWithoutMeasurements) {
  VelocityEstimate estimate;
  estimate.Take(kVelocity.Over(kDurationS), Exact(), kDurationS);
  double before = 0;
  for (int i = 0; i < 5; ++i) {
    const double sigma = std::sqrt(estimate.MoveOn(kDurationS).covariance(0, 0));
    EXPECT_GT(sigma, before);
    before = sigma;
  }
  EXPECT_LT(before, 0.05);
}

}  // namespace
}  // namespace ceilmap::localization
