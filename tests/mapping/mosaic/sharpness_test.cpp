#include "mapping/mosaic/sharpness.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::mosaic {
namespace {

const cv::Size kSize(320, 240);

cv::Mat Ceiling() {
  return registration::synthetic::SyntheticCeiling().Render(kSize);
}

TEST(Sharpness, UniformImagesHaveNone) {
  for (const int grey : {0, 128, 255}) {
    EXPECT_EQ(Sharpness(cv::Mat(kSize, CV_8UC1, cv::Scalar(grey))), 0);
  }
}

TEST(Sharpness, TooSmallImagesHaveNone) {
  for (const cv::Size size : {cv::Size(1, 1), {7, 240}, {320, 7}}) {
    cv::Mat noise(size, CV_8UC1);
    cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
    EXPECT_EQ(Sharpness(noise), 0) << size;
  }
  EXPECT_EQ(Sharpness(cv::Mat()), 0);
  cv::Mat smallest(8, 8, CV_8UC1);
  cv::RNG(1).fill(smallest, cv::RNG::UNIFORM, 0, 256);
  EXPECT_GT(Sharpness(smallest), 0);
}

TEST(Sharpness, FallsWithASoftFocusStepByStep) {
  const cv::Mat sharp = Ceiling();
  double before = Sharpness(sharp);
  EXPECT_GT(before, 0);
  for (const double sigma : {1.0, 2.0, 4.0}) {
    cv::Mat soft;
    cv::GaussianBlur(sharp, soft, {}, sigma);
    const double now = Sharpness(soft);
    EXPECT_LT(now, 0.9 * before) << sigma;
    EXPECT_GT(now, 0) << sigma;
    before = now;
  }
}

TEST(Sharpness, FallsWithMotionInAnyDirection) {
  const cv::Mat still = Ceiling();
  for (const cv::Size smear : {cv::Size(9, 1), {1, 9}}) {
    cv::Mat moved;
    cv::blur(still, moved, smear);
    EXPECT_LT(Sharpness(moved), 0.9 * Sharpness(still)) << smear;
  }
}

TEST(Sharpness, BrightnessAndContrastCancel) {
  const cv::Mat image = Ceiling();
  const double sharpness = Sharpness(image);
  const auto under_other_light = [&](double gain, double offset) {
    cv::Mat other;
    image.convertTo(other, CV_8U, gain, offset);
    return Sharpness(other);
  };
  EXPECT_NEAR(under_other_light(1, 20), sharpness, 0.1 * sharpness);
  EXPECT_NEAR(under_other_light(1, -30), sharpness, 0.1 * sharpness);
  EXPECT_NEAR(under_other_light(0.5, 0), sharpness, 0.1 * sharpness);
  EXPECT_NEAR(under_other_light(1.15, -10), sharpness, 0.1 * sharpness);
  EXPECT_NEAR(under_other_light(0.6, 80), sharpness, 0.1 * sharpness);
}

}  // namespace
}  // namespace ceilmap::mosaic
