#include "localization/compass/parallax_fit.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "calib/base/error.hpp"

namespace ceilmap::compass {
namespace {

using std::numbers::pi;
constexpr int kSectors = 36;

/// Panorama of a robot in a round room, away from its middle: nearness is smooth around the circle.
std::vector<SectorShift> Shifts(double turn, double direction, double nearness, double lopsided) {
  std::vector<SectorShift> shifts;
  for (int i = 0; i < kSectors; ++i) {
    const double azimuth = pi - 2 * pi * (i + 0.5) / kSectors;
    const double near = nearness * (1 + lopsided * std::cos(azimuth - 1));
    shifts.push_back({azimuth, turn + near * std::sin(azimuth - direction), 1e-6});
  }
  return shifts;
}

TEST(ParallaxFit, SeparatesTurnFromTravel) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int round = 0; round < 50; ++round) {
    const double turn = 0.3 * unit(random);
    const double direction = 3 * kRadPerDeg * unit(random);
    const double nearness = 0.06 * unit(random);  // backwards, too
    const auto shifts = Shifts(turn, direction, nearness, 0.4 * unit(random));
    const ParallaxFit fit = FitParallax(shifts, kSectors, 0);
    // The prior holds the lopsidedness back a little.
    EXPECT_NEAR(fit.rotation_rad, turn, 0.03 * std::abs(nearness) + 1e-4) << round;
    EXPECT_NEAR(fit.parallax_rad, nearness, 0.1 * std::abs(nearness) + 1e-4) << round;
    EXPECT_EQ(fit.inlier_ratio, 1);
    EXPECT_GT(fit.variance_rad2, 0);
    EXPECT_LT(std::abs(fit.rotation_rad - turn), 3 * std::sqrt(fit.variance_rad2)) << round;
  }
}

/// The mean of the shifts is what a compass without fields of view takes for the turn.
TEST(ParallaxFit, IsNotDrawnByWhatIsNear) {
  const auto shifts = Shifts(0.1, 0, 0.05, 0.6);
  double mean = 0;
  for (const SectorShift& shift : shifts) mean += shift.shift_rad / kSectors;
  const ParallaxFit fit = FitParallax(shifts, kSectors, 0);
  EXPECT_GT(std::abs(mean - 0.1), 0.01);
  EXPECT_LT(std::abs(fit.rotation_rad - 0.1), 0.001);
}

// Something near at the left side, with sharper edges than the smooth nearness has: the directions
// ahead and behind count most, where it has no effect.
TEST(ParallaxFit, AheadAndBehindCountMost) {
  auto shifts = Shifts(0.1, 0, 0.06, 0);
  for (SectorShift& shift : shifts) {
    const bool near = shift.azimuth_rad > 50 * kRadPerDeg && shift.azimuth_rad < 130 * kRadPerDeg;
    if (near) shift.shift_rad += 0.06 * std::sin(shift.azimuth_rad);
  }
  EXPECT_NEAR(FitParallax(shifts, kSectors, 0).rotation_rad, 0.1, 5e-4);
}

TEST(ParallaxFit, FindsTheDirectionOfTravel) {
  const ParallaxFit fit = FitParallax(Shifts(0, 5 * kRadPerDeg, 0.06, 0.2), kSectors, 0);
  EXPECT_NEAR(fit.direction_rad, 5 * kRadPerDeg, 1 * kRadPerDeg);
}

TEST(ParallaxFit, OfAnyDirectionFindsItAllAround) {
  for (int degrees = -180; degrees < 180; degrees += 15) {
    const auto shifts = Shifts(0.1, degrees * kRadPerDeg, 0.06, 0.3);
    const ParallaxFit fit = FitParallaxOfAnyDirection(shifts, kSectors);
    EXPECT_NEAR(fit.rotation_rad, 0.1, 0.004) << degrees;
    EXPECT_LT(std::abs(fit.rotation_rad - 0.1), 3 * std::sqrt(fit.variance_rad2)) << degrees;
    EXPECT_NEAR(std::cos(2 * (fit.direction_rad - degrees * kRadPerDeg)), 1, 0.05) << degrees;
    // A wrong expectation costs.
    EXPECT_LT(fit.cost, FitParallax(shifts, kSectors, (degrees + 80) * kRadPerDeg).cost) << degrees;
  }
}

TEST(ParallaxFit, OfAnyDirectionHasALargeVarianceWhereSeveralFit) {
  // Shifts known so badly that they hardly favour one direction.
  auto shifts = Shifts(0.1, 50 * kRadPerDeg, 0.06, 0.6);
  for (SectorShift& shift : shifts) shift.variance_rad2 = 0.03 * 0.03;
  const ParallaxFit fit = FitParallaxOfAnyDirection(shifts, kSectors);
  EXPECT_GT(fit.variance_rad2, FitParallax(shifts, kSectors, 50 * kRadPerDeg).variance_rad2);
}

TEST(ParallaxFit, LeavesOutWhatMovesByItself) {
  auto shifts = Shifts(0.05, 0, 0.03, 0.2);
  for (std::size_t i = 15; i < 22; ++i) shifts[i].shift_rad += 0.12;  // a car ahead
  const ParallaxFit fit = FitParallax(shifts, kSectors, 0);
  EXPECT_NEAR(fit.rotation_rad, 0.05, 0.004);
  EXPECT_NEAR(fit.inlier_ratio, 29.0 / 36, 1e-9);
}

TEST(ParallaxFit, ASectorCountsByItsVariance) {
  auto shifts = Shifts(0.05, 0, 0.03, 0.2);
  for (std::size_t i = 0; i < shifts.size(); i += 2) {
    shifts[i].shift_rad += 0.02;
    shifts[i].variance_rad2 = 1;
  }
  EXPECT_NEAR(FitParallax(shifts, kSectors, 0).rotation_rad, 0.05, 0.001);
}

TEST(ParallaxFit, HasNoResultWithTooFewSectors) {
  auto shifts = Shifts(0.05, 0, 0.03, 0);
  shifts.resize(5);
  const ParallaxFit fit = FitParallax(shifts, kSectors, 0);
  EXPECT_TRUE(std::isinf(fit.variance_rad2));
  EXPECT_EQ(fit.inlier_ratio, 0);
}

TEST(ParallaxFit, FewerSectorsMeanALargerVariance) {
  auto shifts = Shifts(0.05, 0, 0.03, 0);
  const double all = FitParallax(shifts, kSectors, 0).variance_rad2;
  shifts.erase(shifts.begin() + 10, shifts.end());
  EXPECT_GT(FitParallax(shifts, kSectors, 0).variance_rad2, 2 * all);
}

}  // namespace
}  // namespace ceilmap::compass
