#include "compensation/tilt_filter.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

namespace ceilmap::compensation {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

TiltAngles Angles(double pitch, double roll, double sigma) {
  return {Vector2d(pitch, roll), sigma * sigma * Matrix2d::Identity()};
}

TEST(TiltFilter, StartsLevelWithALargeCovariance) {
  TiltFilter filter;
  filter.Predict(100);
  EXPECT_EQ(filter.Now().angles, Vector2d(0, 0));
  EXPECT_TRUE(filter.Now().covariance.isApprox(0.01 * Matrix2d::Identity()));
  // The same variance as the prediction: half-way.
  EXPECT_TRUE(filter.Update(Angles(0.06, -0.04, 0.1)));
  EXPECT_TRUE(filter.Now().angles.isApprox(Vector2d(0.03, -0.02)));
  EXPECT_TRUE(filter.Now().covariance.isApprox(0.005 * Matrix2d::Identity()));
}

TEST(TiltFilter, WeighsEachAngleByItsCovariance) {
  TiltFilter filter;
  filter.Predict(0);
  TiltAngles measured{{0.05, 0.05}, Matrix2d::Zero()};
  measured.covariance.diagonal() << 1e-10, 1;
  EXPECT_TRUE(filter.Update(measured));
  EXPECT_NEAR(filter.Now().angles[0], 0.05, 1e-6);
  EXPECT_NEAR(filter.Now().angles[1], 0.05 * 0.01 / 1.01, 1e-9);
  EXPECT_LT(filter.Now().covariance(0, 0), 1.1e-10);
  EXPECT_NEAR(filter.Now().covariance(1, 1), 0.01 / 1.01, 1e-9);
}

// 4.6 degrees up and down within 2 s, by measurements of 0.05 degrees, ten a second.
TEST(TiltFilter, FollowsABump) {
  TiltFilter filter;
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0, 0.05 * kRadPerDeg);
  double sum2 = 0;
  int predictions_off = 0;
  for (int i = 0; i < 60; ++i) {
    const double time_s = 0.1 * i;
    const double part =
        time_s > 2 && time_s < 4 ? (1 - std::cos(std::numbers::pi * time_s)) / 2 : 0;
    const Vector2d truth = part * Vector2d(-4.6 * kRadPerDeg, 1.5 * kRadPerDeg);
    filter.Predict(time_s);
    const TiltAngles expected = filter.Now();
    const Vector2d off = expected.angles - truth;
    if (off.dot(expected.covariance.inverse() * off) > 9) ++predictions_off;
    EXPECT_TRUE(filter.Update(
        Angles(truth[0] + normal(random), truth[1] + normal(random), 0.05 * kRadPerDeg)));
    EXPECT_LT((filter.Now().angles - truth).norm(), 0.2 * kRadPerDeg) << i;
    EXPECT_LE(std::sqrt(filter.Now().covariance(0, 0)), 0.05 * kRadPerDeg);
    sum2 += (filter.Now().angles - truth).squaredNorm();
  }
  EXPECT_LT(std::sqrt(sum2 / 120), 0.055 * kRadPerDeg);
  EXPECT_LE(predictions_off, 2);
}

/// A filter that was shown angles that grow evenly, by 0.1 rad/s, until 1 s.
TiltFilter Rising(const TiltFilterParams& params = {}) {
  TiltFilter filter(params);
  for (int i = 0; i <= 10; ++i) {
    filter.Predict(0.1 * i);
    EXPECT_TRUE(filter.Update(Angles(0.01 * i, -0.005 * i, 1e-5)));
  }
  return filter;
}

TEST(TiltFilter, PredictsWithTheMeasuredRates) {
  TiltFilter filter = Rising();
  filter.Predict(1.4);
  EXPECT_NEAR(filter.Now().angles[0], 0.14, 1e-3);
  EXPECT_NEAR(filter.Now().angles[1], -0.07, 1e-3);
}

TEST(TiltFilter, ForgetsRatesAfterAGap) {
  TiltFilter filter = Rising();
  const TiltAngles before = filter.Now();
  filter.Predict(1.6);
  EXPECT_NEAR((filter.Now().angles - before.angles).norm(), 0, 1e-12);
  // 0.6 s at a rate of 0.5 rad/s, pushed by 3 rad/s^2.
  const double variance = std::pow(0.6 * 0.5, 2) + std::pow(3 * 0.18, 2);
  EXPECT_NEAR(filter.Now().covariance(0, 0), before.covariance(0, 0) + variance, 1e-9);
  EXPECT_NEAR(filter.Now().covariance(0, 1), 0, 1e-12);
}

TEST(TiltFilter, BridgesSingleFramesOnly) {
  TiltFilter filter = Rising();
  filter.Predict(1.1);
  EXPECT_NEAR(filter.Now().angles[0], 0.11, 1e-3);
  for (int i = 2; i <= 20; ++i) filter.Predict(1 + 0.1 * i);
  EXPECT_NEAR(filter.Now().angles[0], 0.11, 1e-3);
}

TEST(TiltFilter, RefusesAnOutlierAndStaysAsItWas) {
  TiltFilter filter = Rising();
  filter.Predict(1.1);
  const TiltAngles before = filter.Now();
  // 3 rad/s^2 explain 0.015 rad within 0.1 s; five times that is too much.
  EXPECT_FALSE(filter.Update(Angles(0.11 + 0.1, -0.055, 1e-5)));
  EXPECT_FALSE(filter.Update(Angles(0.11, -0.055 - 0.1, 1e-5)));
  EXPECT_FALSE(filter.Update(Angles(std::nan(""), 0, 1e-5)));
  EXPECT_EQ(filter.Now().angles, before.angles);
  EXPECT_EQ(filter.Now().covariance, before.covariance);
  EXPECT_TRUE(filter.Update(Angles(0.11 + 0.06, -0.055, 1e-5)));
  // The same outlier with a variance as large is accepted.
  filter = Rising();
  filter.Predict(1.1);
  EXPECT_TRUE(filter.Update(Angles(0.11 + 0.1, -0.055, 0.05)));
}

TEST(TiltFilter, CovarianceGrowsWithoutMeasurements) {
  TiltFilter filter = Rising();
  double last = filter.Now().covariance(0, 0);
  for (int i = 1; i <= 20; ++i) {
    filter.Predict(1 + 0.1 * i);
    const Matrix2d covariance = filter.Now().covariance;
    EXPECT_GT(covariance(0, 0), last);
    EXPECT_NEAR(covariance(1, 1), covariance(0, 0), 1e-12);
    last = covariance(0, 0);
  }
  EXPECT_GT(std::sqrt(last), 1);  // two seconds without measurements
}

TEST(TiltFilter, RestartsWithTheGivenTilt) {
  TiltFilter filter = Rising();
  filter.Predict(1.1);
  const TiltAngles accurate = Angles(-0.07, 0.02, 1e-3);
  filter.Restart(accurate);
  EXPECT_EQ(filter.Now().angles, accurate.angles);
  EXPECT_EQ(filter.Now().covariance, accurate.covariance);
  filter.Predict(1.2);  // the old rates are gone
  EXPECT_NEAR((filter.Now().angles - accurate.angles).norm(), 0, 1e-12);
  const double variance = 1e-6 + std::pow(0.1 * 0.5, 2) + std::pow(3 * 0.005, 2);
  EXPECT_NEAR(filter.Now().covariance(1, 1), variance, 1e-12);
}

}  // namespace
}  // namespace ceilmap::compensation
