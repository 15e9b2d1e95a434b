#include "localization/compass/colour/feature_similarity.hpp"

#include <gtest/gtest.h>

#include <random>

#include "calib/base/error.hpp"

namespace ceilmap::colour {
namespace {

// 1 - (0.5 + 0.1) / 2 = 0.7 times 0.4, and 1 - (0 + 0.4) / 2 = 0.8 times 0.4.
TEST(FeatureDifference, IsWeightedByOneMinusTheFrequency) {
  const Eigen::VectorXf f = Eigen::Vector4f(0.5F, 0, 0.5F, 0);
  const Eigen::VectorXf g = Eigen::Vector4f(0.1F, 0.4F, 0.5F, 0);
  EXPECT_NEAR(FeatureDifference(f, g), 0.7 * 0.4 + 0.8 * 0.4, 1e-6);
  EXPECT_EQ(FeatureDifference(f, f), 0);
}

// The white wall with a red stripe of the paper: the same change counts more where it is rare.
TEST(FeatureDifference, RareTransitionsCountMore) {
  const Eigen::VectorXf wall = Eigen::Vector3f(0.9F, 0.1F, 0);
  const Eigen::VectorXf less_wall = Eigen::Vector3f(0.8F, 0.1F, 0);
  const Eigen::VectorXf no_stripe = Eigen::Vector3f(0.9F, 0, 0);
  EXPECT_GT(FeatureDifference(wall, no_stripe), 5 * FeatureDifference(wall, less_wall));
}

TEST(FeatureDifference, IsSymmetricAndBelowTwo) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int i = 0; i < 100; ++i) {
    Eigen::VectorXf f = Eigen::VectorXf::NullaryExpr(16, [&] { return uniform(random); });
    Eigen::VectorXf g = Eigen::VectorXf::NullaryExpr(16, [&] { return uniform(random); });
    f /= f.sum();
    g /= g.sum();
    EXPECT_NEAR(FeatureDifference(f, g), FeatureDifference(g, f), 1e-6);
    EXPECT_GT(FeatureDifference(f, g), 0);
    EXPECT_LT(FeatureDifference(f, g), 2);
  }
}

TEST(Similarity, IsTheProductOfThePaper) {
  EXPECT_NEAR(Similarity({.distance_m = 2,
                          .angle_rad = 0.5,
                          .difference = 0.25,
                          .certainty_1 = 0.8,
                          .certainty_2 = 0.5},
                         {}),
              1 / 2. * 1 / 0.5 * 1 / 0.25 * 0.8 * 0.5,
              1e-12);
}

TEST(Similarity, DifferencesOfZeroCountAsTheLimits) {
  const SimilarityLimits limits{.distance_m = 0.1, .angle_rad = 0.02, .difference = 0.01};
  const FeaturePair equal{.distance_m = 0, .angle_rad = 0, .difference = 0};
  EXPECT_NEAR(Similarity(equal, limits), 10 * 50 * 100, 1e-6);
}

TEST(Similarity, UnknownDifferencesAreLeftOut) {
  EXPECT_NEAR(Similarity({.difference = 0.5}, {}), 2, 1e-12);
  EXPECT_NEAR(Similarity({.distance_m = 4, .difference = 0.5}, {}), 0.5, 1e-12);
}

TEST(Similarity, RefusesLimitsThatAreNotPositive) {
  EXPECT_THROW(SimilarityLimits{.distance_m = 0}.Validate(), InputError);
  EXPECT_THROW(SimilarityLimits{.angle_rad = 0}.Validate(), InputError);
  EXPECT_THROW(SimilarityLimits{.difference = 0}.Validate(), InputError);
}

}  // namespace
}  // namespace ceilmap::colour
