#include "mapping/change/cell_comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ceilmap::change {
namespace {

constexpr int kSide = 16;

/// Noise of a texture around a mean.
cv::Mat Texture(std::uint64_t seed, double mean, double contrast) {
  cv::Mat texture(kSide, kSide, CV_32FC1);
  cv::RNG rng(seed);
  rng.fill(texture, cv::RNG::NORMAL, mean, contrast);
  return texture;
}

CellState StateBetween(const cv::Mat& a, const cv::Mat& b, double noise = 0.1) {
  const CellSums sums = SumsOver(a, b);
  return StateOf(Compare(sums, noise), sums.MeanA(), noise);
}

TEST(CellComparison, SumsAreExact) {
  const cv::Mat a(2, 2, CV_32FC1, cv::Scalar(3));
  const cv::Mat b = (cv::Mat_<float>(2, 2) << 1, 2, 3, 4);
  const CellSums sums = SumsOver(a, b);
  EXPECT_EQ(sums.pixels, 4);
  EXPECT_EQ(sums.MeanA(), 3);
  EXPECT_EQ(sums.MeanB(), 2.5);
  EXPECT_EQ(sums.aa, 36);
  EXPECT_EQ(sums.bb, 30);
  EXPECT_EQ(sums.ab, 30);
}

TEST(CellComparison, ShareOfTheDifference) {
  const cv::Mat a = Texture(1, 120, 10);
  const cv::Mat b = Texture(2, 120, 10);
  EXPECT_NEAR(Compare(SumsOver(a, a), 0).Share(), 0, 1e-3);
  EXPECT_NEAR(Compare(SumsOver(a, b), 0).Share(), 1, 0.15);
  const cv::Mat half =
      0.5 * a + 0.5 * b;  // a quarter of the sum of variances, three eighths in all
  EXPECT_NEAR(Compare(SumsOver(a, half), 0).Share(), 1.0 / 3, 0.1);
}

TEST(CellComparison, AnotherTextureDiffersTheSameDoesNot) {
  const cv::Mat a = Texture(1, 120, 8);
  EXPECT_EQ(StateBetween(a, Texture(1, 120, 8)), CellState::kSame);
  EXPECT_EQ(StateBetween(a, Texture(2, 120, 8)), CellState::kTexture);
  EXPECT_EQ(StateBetween(a, cv::Mat(kSide, kSide, CV_32FC1, cv::Scalar(120))), CellState::kTexture);
}

TEST(CellComparison, NoiseIsNoTexture) {
  const double sigma = 3;
  EXPECT_EQ(StateBetween(Texture(1, 120, sigma), Texture(2, 120, sigma), 2 * sigma * sigma),
            CellState::kSame);
}

TEST(CellComparison, ASunPatchIsNoOtherTexture) {
  const cv::Mat a = Texture(1, 120, 8);
  EXPECT_EQ(StateBetween(a, 1.5 * a), CellState::kUnclear);
}

TEST(CellComparison, BrightnessWithoutTexture) {
  const cv::Mat a(kSide, kSide, CV_32FC1, cv::Scalar(120));
  EXPECT_EQ(StateBetween(a, 1.005 * a), CellState::kSame);
  EXPECT_EQ(StateBetween(a, 1.05 * a), CellState::kUnclear);
  EXPECT_EQ(StateBetween(a, 1.3 * a), CellState::kBrightness);
  EXPECT_EQ(StateBetween(a, a / 1.3), CellState::kBrightness);
}

}  // namespace
}  // namespace ceilmap::change
