#include "app/evaluation/robust_line.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace ceilmap::evaluation {
namespace {

TEST(RobustSlope, IsExactOnALine) {
  EXPECT_NEAR(
      RobustSlope(std::vector{0.0, 1.0, 3.0}, std::vector{5.0, 3.0, -1.0}).value(), -2, 1e-12);
  EXPECT_NEAR(RobustSlope(std::vector{1.0, 2.0}, std::vector{4.0, 4.5}).value(), 0.5, 1e-12);
  EXPECT_EQ(RobustSlope(std::vector{2.0, 2.0, 2.0}, std::vector{1.0, 5.0, 3.0}), std::nullopt);
  EXPECT_EQ(RobustSlope({}, {}), std::nullopt);
}

TEST(RobustSlope, IgnoresOutliers) {
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < 50; ++i) {
    x.push_back(0.1 * i);
    y.push_back(2 + 0.3 * x.back() + (i % 2 == 0 ? 0.01 : -0.01));
  }
  for (const int i : {3, 7, 12, 40, 41, 42}) y[i] += 20 + i;
  EXPECT_NEAR(RobustSlope(x, y).value(), 0.3, 0.005);
}

// Where nothing is an outlier it is nearly least squares, which is best for normal errors.
TEST(RobustSlope, IsNearlyTheBestForNormalErrors) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 1);
  double squares = 0;
  constexpr int kTrials = 300;
  constexpr int kPoints = 60;
  double xx = 0;
  std::vector<double> x(kPoints);
  for (int i = 0; i < kPoints; ++i) {
    x[i] = i - 0.5 * (kPoints - 1);
    xx += x[i] * x[i];
  }
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> y(kPoints);
    for (int i = 0; i < kPoints; ++i) y[i] = 0.7 * x[i] + noise(random);
    const double error = RobustSlope(x, y).value() - 0.7;
    squares += error * error * xx;
  }
  EXPECT_NEAR(squares / kTrials, 1 / 0.95, 0.2);
}

}  // namespace
}  // namespace ceilmap::evaluation
