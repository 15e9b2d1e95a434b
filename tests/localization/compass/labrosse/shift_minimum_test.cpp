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
    const auto sharp = Around([&](double s) { return 2 + 5 * std::abs(s - at); });
    for (const SubPixelMinimum found : {ParabolicMinimum(parabola), BlendedMinimum(parabola, 0)}) {
      EXPECT_NEAR(found.shift, at, 1e-12);
      EXPECT_NEAR(found.distance, 7, 1e-12);
    }
    for (const SubPixelMinimum found : {LinearMinimum(sharp), BlendedMinimum(sharp, 1)}) {
      EXPECT_NEAR(found.shift, at, 1e-12);
      EXPECT_NEAR(found.distance, 2, 1e-12);
    }
  }
}

// The parabola through (6, 2, 4): 2 / (2 * 6), 2 - 4 / (8 * 6); the V: 2 / (2 * 4), 2 - 2 / 2.
TEST(ShiftMinimum, BlendsBoth) {
  const ShiftNeighbours distances{6, 2, 4};
  EXPECT_DOUBLE_EQ(ParabolicMinimum(distances).shift, 1.0 / 6);
  EXPECT_DOUBLE_EQ(ParabolicMinimum(distances).distance, 23.0 / 12);
  EXPECT_DOUBLE_EQ(LinearMinimum(distances).shift, 0.25);
  EXPECT_DOUBLE_EQ(LinearMinimum(distances).distance, 1);
  const SubPixelMinimum blended = BlendedMinimum(distances, 0.75);
  EXPECT_DOUBLE_EQ(blended.shift, 0.75 * 0.25 + 0.25 / 6);
  EXPECT_DOUBLE_EQ(blended.distance, 0.75 + 0.25 * 23 / 12);
}

// Labrosse 2006, Eq. 10.
TEST(ShiftMinimum, IsParabolicUpToHalfTheAmplitude) {
  EXPECT_EQ(LinearPart(-0.1), 0);
  EXPECT_EQ(LinearPart(0.5), 0);
  EXPECT_DOUBLE_EQ(LinearPart(0.6), 0.2);
  EXPECT_EQ(LinearPart(1), 1);
  EXPECT_EQ(LinearPart(1.2), 1);
}

TEST(ShiftMinimum, StaysWithinHalfAColumnAndMirrors) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> value(0, 1);
  for (int i = 0; i < 1000; ++i) {
    const double least = value(random);
    const ShiftNeighbours distances{least + value(random), least, least + value(random)};
    const ShiftNeighbours mirrored{distances.right, least, distances.left};
    const double p = value(random);
    const SubPixelMinimum minimum = BlendedMinimum(distances, p);
    EXPECT_LE(std::abs(minimum.shift), 0.5);
    EXPECT_LE(minimum.distance, least);
    EXPECT_NEAR(BlendedMinimum(mirrored, p).shift, -minimum.shift, 1e-15);
    EXPECT_NEAR(BlendedMinimum(mirrored, p).distance, minimum.distance, 1e-15);
    EXPECT_EQ(minimum.shift > 0, distances.right < distances.left);
  }
}

TEST(ShiftMinimum, OfFlatDistancesIsTheMiddle) {
  for (const SubPixelMinimum found : {ParabolicMinimum({3, 3, 3}), LinearMinimum({3, 3, 3})}) {
    EXPECT_EQ(found.shift, 0);
    EXPECT_EQ(found.distance, 3);
  }
  EXPECT_EQ(ShiftVariance({3, 3, 3}, 10), std::numeric_limits<double>::infinity());
}

TEST(ShiftMinimum, DepthByHand) {
  EXPECT_DOUBLE_EQ(RelativeDepth(std::array{5.0, 2.0, 8.0}), 0.75);
  EXPECT_EQ(RelativeDepth(std::array{5.0, 0.0}), 1);
  EXPECT_EQ(RelativeDepth(std::array{5.0, 5.0}), 0);
  EXPECT_EQ(RelativeDepth(std::array{0.0, 0.0}), 0);
  EXPECT_EQ(RelativeDepth({}), 0);
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
    const double shift = ParabolicMinimum(squared).shift;
    squares += shift * shift;
    variances +=
        ShiftVariance({std::sqrt(sums[0]), std::sqrt(sums[1]), std::sqrt(sums[2])}, kColumns);
  }
  EXPECT_NEAR(squares / variances, 1, 0.1);
}

}  // namespace
}  // namespace ceilmap::labrosse
