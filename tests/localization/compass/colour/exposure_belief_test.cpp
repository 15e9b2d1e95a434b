#include "localization/compass/colour/exposure_belief.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace ceilmap::colour {
namespace {

constexpr int kMiddle = ExposureBelief::kFactors / 2;

double Sum(const ExposureBelief& belief) {
  double sum = 0;
  for (int i = 0; i < ExposureBelief::kFactors; ++i) sum += belief.Probability(i);
  return sum;
}

// Weighs as if the factor `wanted` were right: each step off it costs `cost`.
void WeighFor(int wanted, double cost, ExposureBelief& belief) {
  std::vector<double> fit;
  for (const int live : belief.Live()) fit.push_back(-cost * std::abs(live - wanted));
  belief.Weigh(fit);
}

TEST(ExposureBelief, BeginsAboutOne) {
  const ExposureBelief belief(0.15);
  EXPECT_EQ(belief.Best(), kMiddle);
  EXPECT_DOUBLE_EQ(ExposureBelief::Factor(kMiddle), 1);
  EXPECT_NEAR(ExposureBelief::Factor(kMiddle + 2), std::exp(2 * ExposureBelief::kStep), 1e-12);
  EXPECT_NEAR(Sum(belief), 1, 1e-12);
  EXPECT_EQ(belief.Live().size(), ExposureBelief::kFactors);
  EXPECT_NEAR(belief.Probability(kMiddle - 3) / belief.Probability(kMiddle), std::exp(-0.5), 1e-9)
      << "three steps are one sigma";
}

TEST(ExposureBelief, WithoutAnyIsOneForEver) {
  ExposureBelief belief(0);
  ASSERT_EQ(belief.Live().size(), 1U);
  EXPECT_EQ(belief.Live()[0], kMiddle);
  const double fit[] = {-20};
  belief.Weigh(fit);
  belief.Drift(0);
  EXPECT_EQ(belief.Probability(kMiddle), 1);
}

TEST(ExposureBelief, FindsTheOneThatFitsAndDropsTheOthers) {
  ExposureBelief belief(0.15);
  for (int i = 0; i < 5; ++i) WeighFor(kMiddle + 3, 2, belief);
  EXPECT_EQ(belief.Best(), kMiddle + 3);
  EXPECT_LE(belief.Live().size(), 3U) << "cost of a frame";
  EXPECT_NEAR(Sum(belief), 1, 1e-9);
}

TEST(ExposureBelief, FollowsALampThatIsSwitchedOff) {
  ExposureBelief belief(0.15);
  for (int i = 0; i < 20; ++i) WeighFor(kMiddle - 2, 2, belief);
  ASSERT_EQ(belief.Best(), kMiddle - 2);
  int frames = 0;
  while (belief.Best() != kMiddle + 3 && ++frames < 100) {
    belief.Drift(0.01);
    WeighFor(kMiddle + 3, 2, belief);
  }
  EXPECT_LT(frames, 30);
}

TEST(ExposureBelief, StaysWithinItsEnds) {
  ExposureBelief belief(0.3);
  for (int i = 0; i < 20; ++i) {
    belief.Drift(0.5);
    WeighFor(ExposureBelief::kFactors + 5, 3, belief);
  }
  EXPECT_EQ(belief.Best(), ExposureBelief::kFactors - 1);
  EXPECT_NEAR(Sum(belief), 1, 1e-9);
}

TEST(ExposureBelief, SaturatedValuesStaySaturated) {
  const auto darker = ExposureBelief::Table(0);
  const auto brighter = ExposureBelief::Table(ExposureBelief::kFactors - 1);
  EXPECT_EQ(darker[255], 255);
  EXPECT_EQ(darker[100], 74);  // 100 e^-0.3
  EXPECT_EQ(brighter[100], 135);
  EXPECT_EQ(brighter[240], 255);
  EXPECT_EQ(brighter[0], 0);
}

}  // namespace
}  // namespace ceilmap::colour
