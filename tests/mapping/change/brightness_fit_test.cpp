#include "mapping/change/brightness_fit.hpp"

#include <gtest/gtest.h>

#include <random>

namespace ceilmap::change {
namespace {

double Truth(const cv::Point2d& p) {
  return -0.3 + 0.001 * p.x - 0.0005 * p.y + 1e-6 * p.x * p.x - 2e-6 * p.x * p.y;
}

TEST(BrightnessFit, FollowsSlowLightAlthoughAThirdDiffers) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0, 400);
  std::normal_distribution<double> noise(0, 0.004);
  std::vector<BrightnessFit::Sample> samples;
  for (int i = 0; i < 300; ++i) {
    const cv::Point2d at(place(random), place(random));
    samples.push_back({at, Truth(at) + noise(random) + (i % 3 == 0 ? 0.5 : 0)});
  }
  const BrightnessFit fit(samples, {0, 0, 400, 400});
  for (int i = 0; i < 50; ++i) {
    const cv::Point2d at(place(random), place(random));
    EXPECT_NEAR(fit.LogRatio(at), Truth(at), 0.01);
  }
}

TEST(BrightnessFit, FewSamplesGiveTheirMedian) {
  EXPECT_EQ(BrightnessFit({}, {0, 0, 1, 1}).LogRatio({0.5, 0.5}), 0);
  const std::vector<BrightnessFit::Sample> samples = {{{0, 0}, 0.1}, {{1, 0}, 5}, {{0, 1}, 0.2}};
  EXPECT_EQ(BrightnessFit(samples, {0, 0, 1, 1}).LogRatio({0.9, 0.9}), 0.2);
}

}  // namespace
}  // namespace ceilmap::change
