#include "calib/base/pose_with_covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace ceilmap {
namespace {

PoseWithCovariance Estimate(const Pose2& pose, const Eigen::Vector3d& variances) {
  PoseWithCovariance estimate{pose};
  estimate.covariance = variances.asDiagonal();
  return estimate;
}

TEST(Fused, WeighsByInformation) {
  const PoseWithCovariance a = Estimate({1, 2, 0.1}, {1, 4, 0.01});
  const PoseWithCovariance b = Estimate({5, 7, 0.4}, {3, 1, 0.02});
  const PoseWithCovariance fused = Fused(a, b);
  EXPECT_NEAR(fused.pose.x, 2, 1e-12);      // a quarter of the way to b
  EXPECT_NEAR(fused.pose.y, 6, 1e-12);      // four fifths
  EXPECT_NEAR(fused.pose.yaw, 0.2, 1e-12);  // a third
  EXPECT_NEAR(fused.covariance(0, 0), 0.75, 1e-12);
  EXPECT_NEAR(fused.covariance(1, 1), 0.8, 1e-12);
  EXPECT_NEAR(fused.covariance(2, 2), 0.02 / 3, 1e-12);
}

/// Two estimates whose errors are correlated, in different ways.
PoseWithCovariance Correlated(const Pose2& pose, double sign) {
  PoseWithCovariance estimate{pose};
  estimate.covariance << 0.3, 0.1 * sign, 0.05, 0.1 * sign, 0.2, 0.02 * sign, 0.05, 0.02 * sign,
      0.04;
  return estimate;
}

TEST(Fused, AddsTheInformationOfBoth) {
  const PoseWithCovariance a = Correlated({1, 2, 0.3}, 1);
  const PoseWithCovariance b = Correlated({1.4, 1.7, 0.1}, -1);
  const Eigen::Matrix3d information = a.covariance.inverse() + b.covariance.inverse();
  const Eigen::Vector3d mean =
      information.inverse() *
      (a.covariance.inverse() * Eigen::Vector3d(a.pose.x, a.pose.y, a.pose.yaw) +
       b.covariance.inverse() * Eigen::Vector3d(b.pose.x, b.pose.y, b.pose.yaw));
  const PoseWithCovariance fused = Fused(a, b);
  EXPECT_NEAR((fused.covariance - information.inverse()).norm(), 0, 1e-12);
  EXPECT_NEAR(fused.pose.x, mean.x(), 1e-12);
  EXPECT_NEAR(fused.pose.y, mean.y(), 1e-12);
  EXPECT_NEAR(fused.pose.yaw, mean.z(), 1e-12);
}

TEST(Fused, EqualEstimatesHalveTheCovariance) {
  const PoseWithCovariance a = Correlated({1, 2, 0.3}, 1);
  const PoseWithCovariance fused = Fused(a, a);
  EXPECT_NEAR((fused.covariance - 0.5 * a.covariance).norm(), 0, 1e-12);
  EXPECT_NEAR(fused.pose.x, a.pose.x, 1e-12);
  EXPECT_NEAR(fused.pose.y, a.pose.y, 1e-12);
  EXPECT_NEAR(fused.pose.yaw, a.pose.yaw, 1e-12);
}

TEST(Fused, DoesNotDependOnTheOrder) {
  const PoseWithCovariance a = Correlated({1, 2, 3}, 1);
  const PoseWithCovariance b = Correlated({1.4, 1.7, -3.1}, -1);
  const PoseWithCovariance ab = Fused(a, b);
  const PoseWithCovariance ba = Fused(b, a);
  EXPECT_NEAR(ab.pose.x, ba.pose.x, 1e-12);
  EXPECT_NEAR(ab.pose.y, ba.pose.y, 1e-12);
  EXPECT_NEAR(WrapAngle(ab.pose.yaw - ba.pose.yaw), 0, 1e-12);
  EXPECT_NEAR((ab.covariance - ba.covariance).norm(), 0, 1e-12);
}

TEST(Fused, TakesTheShortWayBetweenYaws) {
  constexpr double kHalfTurn = std::numbers::pi;
  const PoseWithCovariance fused = Fused(Estimate({0, 0, kHalfTurn - 0.1}, {1, 1, 1}),
                                         Estimate({0, 0, -kHalfTurn + 0.3}, {1, 1, 1}));
  EXPECT_NEAR(fused.pose.yaw, -kHalfTurn + 0.1, 1e-12);
}

TEST(Fused, AnExactEstimateStays) {
  const PoseWithCovariance fused =
      Fused(Estimate({1, 2, 0.3}, {0, 0, 0}), Estimate({2, 3, 0.5}, {1, 1, 1}));
  EXPECT_NEAR(fused.pose.x, 1, 1e-12);
  EXPECT_NEAR(fused.pose.yaw, 0.3, 1e-12);
  EXPECT_NEAR(fused.covariance.norm(), 0, 1e-12);
}

}  // namespace
}  // namespace ceilmap
