#include "mapping/repetition.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace ceilmap::mapping {
namespace {

cv::Mat NoiseImage(int seed) {
  cv::Mat image(96, 128, CV_8UC1);
  cv::RNG(static_cast<std::uint64_t>(seed)).fill(image, cv::RNG::UNIFORM, 40, 200);
  return image;
}

TEST(RepetitionMeter, CountsBlocksThatAreCopies) {
  RepetitionMeter meter;
  const cv::Mat first = NoiseImage(1);
  EXPECT_EQ(meter.Next(first), 0) << "there is no image before";
  EXPECT_EQ(meter.Next(first.clone()), 1);
  cv::Mat half = NoiseImage(2);
  first(cv::Rect(0, 0, 64, 96)).copyTo(half(cv::Rect(0, 0, 64, 96)));
  EXPECT_EQ(meter.Next(half), 0.5);
  EXPECT_EQ(meter.Next(NoiseImage(3)), 0);
}

TEST(RepetitionMeter, OnePixelMakesABlockNew) {
  RepetitionMeter meter;
  cv::Mat image = NoiseImage(1);
  meter.Next(image);
  for (int x = 15; x < image.cols; x += 16) image.at<uchar>(15, x) ^= 1;
  EXPECT_DOUBLE_EQ(meter.Next(image), 5.0 / 6);
}

TEST(RepetitionMeter, SaturatedLampsAndBlackBordersAreNotCounted) {
  RepetitionMeter meter;
  cv::Mat image = NoiseImage(1);
  image(cv::Rect(0, 0, 128, 80)) = cv::Scalar(255);
  meter.Next(image);
  EXPECT_EQ(meter.Next(image.clone()), 1) << "of the blocks with texture";
  cv::Mat black = cv::Mat::zeros(96, 128, CV_8UC1);
  meter.Next(black);
  EXPECT_EQ(meter.Next(black.clone()), 0);
}

TEST(RepetitionMeter, StartsAnewWithAnotherSize) {
  RepetitionMeter meter;
  const cv::Mat image = NoiseImage(1);
  meter.Next(image);
  EXPECT_EQ(meter.Next(image(cv::Rect(0, 0, 64, 64)).clone()), 0);
}

}  // namespace
}  // namespace ceilmap::mapping
