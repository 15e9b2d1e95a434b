#include "localization/compass/labrosse/shift_minimum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace ceilmap::labrosse {
namespace {

template <typename Distance>
ShiftNeighbours Around(const Distance& distance) {
  return {distance(-1.0), distance(0.0), distance(1.0)};
}

TEST(ShiftMinimum, RecoversParabolasAndVs) {
  for (int i = -10; i <= 10; ++i) {
    const double at = i / 20.0;
    const auto parabola = Around([&](double s) { return 7 + 3 * (s - at) * (s - at); });
    EXPECT_NEAR(ParabolaMinimum(parabola), at, 1e-12);
    EXPECT_NEAR(BlendedMinimum(parabola, 0), at, 1e-12);
    const auto sharp = Around([&](double s) { return 2 + 5 * std::abs(s - at); });
    EXPECT_NEAR(VMinimum(sharp), at, 1e-12);
    EXPECT_NEAR(BlendedMinimum(sharp, 1), at, 1e-12);
  }
}

// The parabola through (6, 2, 4): 2 / (2 * 6); the V: 2 / (2 * 4).
TEST(ShiftMinimum, BlendsByTheAmplitude) {
  const ShiftNeighbours distances{6, 2, 4};
  EXPECT_DOUBLE_EQ(ParabolaMinimum(distances), 1.0 / 6);
  EXPECT_DOUBLE_EQ(VMinimum(distances), 0.25);
  EXPECT_DOUBLE_EQ(BlendedMinimum(distances, 0.75), 0.75 * 0.25 + 0.25 / 6);
}

TEST(ShiftMinimum, StaysWithinHalfAColumnAndMirrors) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> value(0, 1);
  for (int i = 0; i < 1000; ++i) {
    const double least = value(random);
    const ShiftNeighbours distances{least + value(random), least, least + value(random)};
    const ShiftNeighbours mirrored{distances.right, least, distances.left};
    const double amplitude = value(random);
    const double minimum = BlendedMinimum(distances, amplitude);
    EXPECT_LE(std::abs(minimum), 0.5);
    EXPECT_NEAR(BlendedMinimum(mirrored, amplitude), -minimum, 1e-15);
    EXPECT_EQ(minimum > 0, distances.right < distances.left);
  }
}

TEST(ShiftMinimum, OfFlatDistancesIsTheMiddle) {
  EXPECT_EQ(ParabolaMinimum({3, 3, 3}), 0);
  EXPECT_EQ(VMinimum({3, 3, 3}), 0);
  EXPECT_EQ(ShiftVariance({3, 3, 3}, 10), std::numeric_limits<double>::infinity());
}

TEST(ShiftMinimum, AmplitudeByHand) {
  EXPECT_DOUBLE_EQ(NormalizedAmplitude(std::array{5.0, 2.0, 8.0}), 0.75);
  EXPECT_EQ(NormalizedAmplitude(std::array{5.0, 0.0}), 1);
  EXPECT_EQ(NormalizedAmplitude(std::array{5.0, 5.0}), 0);
  EXPECT_EQ(NormalizedAmplitude(std::array{0.0, 0.0}), 0);
  EXPECT_EQ(NormalizedAmplitude({}), 0);
}

TEST(ShiftMinimum, VarianceByHand) {
  // Squared: 25, 9, 16; curvature 23.
  EXPECT_DOUBLE_EQ(ShiftVariance({5, 3, 4}, 6), 2 * 9.0 / (6 * 23));
  EXPECT_EQ(ShiftVariance({5, 0, 5}, 6), 0);
}

// Noise on N independent columns of a slope: the scatter of the least-squares shift agrees with its
// variance.
TEST(ShiftMinimum, VarianceIsThatOfTheShift) {
  constexpr int kColumns = 60;
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 4);
  std::array<double, kColumns> slopes{};
  for (double& slope : slopes) slope = 10 * noise(random);
  double squares = 0;
  double variances = 0;
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> sums(3, 0);
    // A world that is a straight line at each column, of that slope.
    for (const double slope : slopes) {
      const double error = noise(random);
      for (int i = 0; i < 3; ++i) sums.at(i) += std::pow(error + (i - 1) * slope, 2);
    }
    const ShiftNeighbours squared{sums[0], sums[1], sums[2]};
    const double shift = ParabolaMinimum(squared);
    squares += shift * shift;
    variances +=
        ShiftVariance({std::sqrt(sums[0]), std::sqrt(sums[1]), std::sqrt(sums[2])}, kColumns);
  }
  EXPECT_NEAR(squares / variances, 1, 0.1);
}

}  // namespace
}  // namespace ceilmap::labrosse
