#include "localization/light_choice.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace ceilmap::localization {
namespace {

/// A ceiling with a lamp of this brightness, of an area of 2 %.
cv::Mat Ceiling(double lamp, std::uint64_t seed) {
  cv::Mat image(120, 160, CV_8UC1);
  cv::RNG rng(seed);
  rng.fill(image, cv::RNG::NORMAL, 120, 4);
  image(cv::Rect(60, 40, 20, 20)).setTo(lamp);
  return image;
}

class LightChoiceTest : public testing::Test {
 protected:
  /// @param lamp  as the robot sees it.
  void See(double lamp, double exposure = 1) {
    cv::Mat image;
    Ceiling(lamp, 3).convertTo(image, -1, exposure);
    choice_.Add(image, Ceiling(250, 1), Ceiling(90, 2), content_);
  }

  LightChoice choice_;
  cv::Mat content_{120, 160, CV_8UC1, cv::Scalar(255)};
};

TEST_F(LightChoiceTest, TwoImagesDecide) {
  EXPECT_FALSE(choice_.IsKnown());
  See(90);
  EXPECT_FALSE(choice_.IsKnown());
  See(90, 0.5);
  EXPECT_TRUE(choice_.IsKnown());
  EXPECT_TRUE(choice_.IsOther());
}

TEST_F(LightChoiceTest, LampsThatAreOnAreTheLightOfTheMap) {
  for (int i = 0; i < 2; ++i) See(250, 0.8);
  EXPECT_TRUE(choice_.IsKnown());
  EXPECT_FALSE(choice_.IsOther());
}

TEST_F(LightChoiceTest, ANewLightIsNoticed) {
  for (int i = 0; i < 50; ++i) See(90);
  for (int i = 0; i < 5; ++i) See(250);
  EXPECT_TRUE(choice_.IsKnown());
  EXPECT_FALSE(choice_.IsOther());
}

TEST_F(LightChoiceTest, WhatFitsNeitherGivesNoVote) {
  cv::Mat noise(120, 160, CV_8UC1);
  cv::RNG rng(9);
  for (int i = 0; i < 5; ++i) {
    rng.fill(noise, cv::RNG::UNIFORM, 50, 200);
    choice_.Add(noise, Ceiling(250, 1), Ceiling(90, 2), content_);
  }
  EXPECT_FALSE(choice_.IsKnown());
}

TEST_F(LightChoiceTest, WhereTheMapHasNoContentNothingIsCompared) {
  content_(cv::Rect(50, 30, 40, 40)).setTo(0);
  for (int i = 0; i < 5; ++i) See(90);
  EXPECT_FALSE(choice_.IsKnown());
}

}  // namespace
}  // namespace ceilmap::localization
