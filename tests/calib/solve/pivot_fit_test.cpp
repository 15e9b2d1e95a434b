#include "calib/solve/pivot_fit.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace ceilmap::calibration {
namespace {
constexpr double kAxle = 0.14;
constexpr double kFront = 0.2;

/// A robot over a board from 0.5 m on, as wide as given; 1 cm a frame.
std::vector<Climb> Over(double height, double width, double noise_m, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  const auto floor = [&](double x) {
    constexpr double kRamp = 0.05;
    const double up = std::clamp((x - 0.5) / kRamp, 0.0, 1.0);
    const double down = std::clamp((0.5 + width - x) / kRamp, 0.0, 1.0);
    return height * std::min(up, down);
  };
  std::vector<Climb> climbs;
  for (int i = 0; i < 200; ++i) {
    const double mast = 0.01 * i;
    const double rear = floor(mast - kAxle);
    const double sine = (floor(mast + kFront) - rear) / (kAxle + kFront);
    climbs.push_back(
        {-std::asin(sine) + 1e-4 * noise(random), rear + kAxle * sine + noise_m * noise(random)});
  }
  return climbs;
}

TEST(PivotFit, ANarrowBoardGivesBoth) {
  const PivotFit fit = FitPivots(Over(0.015, 0.2, 0, 1));
  EXPECT_NEAR(fit.axle.distance_m, kAxle, 0.001);
  EXPECT_NEAR(fit.front_wheels.distance_m, kFront, 0.001);
  EXPECT_NEAR(fit.axle.max_rad, std::asin(0.015 / (kAxle + kFront)), 3e-4);
}

TEST(PivotFit, ARobotThatEndsOnTheBoardGivesOnlyTheAxle) {
  const PivotFit fit = FitPivots(Over(0.015, 10, 0, 2));
  EXPECT_NEAR(fit.axle.distance_m, kAxle, 0.001);
  EXPECT_EQ(fit.front_wheels.frames, 0);
}

TEST(PivotFit, AFirstFrameThatIsOffDoesNotMatter) {
  std::vector<Climb> climbs = Over(0.015, 10, 0, 4);
  for (Climb& climb : climbs) climb.lift_m -= 0.001;
  EXPECT_NEAR(FitPivots(climbs).axle.distance_m, kAxle, 0.001);
}

TEST(PivotFit, TheMastMayStandBehindTheAxle) {
  std::vector<Climb> climbs;
  for (int i = 0; i < 50; ++i) {
    const double up = 3 * kRadPerDeg * std::sin(std::numbers::pi * i / 49);
    climbs.push_back({-up, -0.08 * std::sin(up)});
  }
  EXPECT_NEAR(FitPivots(climbs).axle.distance_m, -0.08, 1e-6);
}

TEST(PivotFit, ErrorsAreAsLargeAsTheirDeviations) {
  double sum = 0;
  constexpr int kTimes = 20;
  for (unsigned i = 0; i < kTimes; ++i) {
    const PivotFit fit = FitPivots(Over(0.02, 0.3, 3e-4, 100 + i));
    const double ratio = (fit.axle.distance_m - kAxle) / fit.axle.sigma_m;
    sum += ratio * ratio;
  }
  EXPECT_LT(sum / kTimes, 2.5);
  EXPECT_GT(sum / kTimes, 0.2);
}

TEST(PivotFit, ALevelFloorHasNone) {
  const PivotFit fit = FitPivots(Over(0, 1, 3e-4, 3));
  EXPECT_EQ(fit.axle.frames, 0);
  EXPECT_EQ(fit.front_wheels.frames, 0);
  EXPECT_EQ(FitPivots({}).axle.frames, 0);
}

}  // namespace
}  // namespace ceilmap::calibration
