#include "mapping/registration/aperiodic.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace ceilmap::registration {
namespace {

constexpr int kTile = 40;
const cv::Size kTilesSize(320, 240);
const std::vector<Eigen::Vector2d> kPeriods{{kTile, 0}, {0, kTile}, {kTile, kTile}};

/// Lines on the borders of square tiles.
cv::Mat Tiles() {
  cv::Mat image(kTilesSize, CV_32FC1, cv::Scalar(2));
  for (int y = 0; y < kTilesSize.height; y += kTile) image.row(y).setTo(-30);
  for (int x = 0; x < kTilesSize.width; x += kTile) image.col(x).setTo(-30);
  return image;
}

TEST(AperiodicPartTest, NothingRemainsOfAGrid) {
  const AperiodicPart part = SplitAperiodic(Tiles(), kPeriods);
  EXPECT_EQ(part.deviation, 0);
  EXPECT_EQ(cv::norm(part.residual, cv::NORM_INF), 0);
  EXPECT_EQ(cv::countNonZero(part.marks), 0);
  EXPECT_EQ(cv::countNonZero(part.panels), 0);
}

TEST(AperiodicPartTest, ASpotIsAMark) {
  cv::Mat image = Tiles();
  cv::circle(image, {138, 97}, 6, cv::Scalar(-40), cv::FILLED);
  const AperiodicPart part = SplitAperiodic(image, kPeriods);
  EXPECT_EQ(part.residual.at<float>(97, 138), -42);
  EXPECT_EQ(part.residual.at<float>(97, 138 + kTile), 0);
  EXPECT_EQ(part.marks.at<unsigned char>(97, 138), 255);
  EXPECT_EQ(cv::countNonZero(part.panels), 0);
  EXPECT_TRUE(std::isnan(part.grain.at<float>(97, 138)));
}

TEST(AperiodicPartTest, AFilledTileIsAPanel) {
  cv::Mat image = Tiles();
  image(cv::Rect(3 * kTile + 1, 2 * kTile + 1, kTile - 1, kTile - 1)).setTo(80);
  const AperiodicPart part = SplitAperiodic(image, kPeriods);
  EXPECT_EQ(part.panels.at<unsigned char>(100, 140), 255);
  EXPECT_EQ(cv::countNonZero(part.marks), 0);
}

TEST(AperiodicPartTest, WhatTheBorderCutsIsNoMark) {
  cv::Mat image = Tiles();
  cv::circle(image, {2, 97}, 6, cv::Scalar(-40), cv::FILLED);
  const AperiodicPart part = SplitAperiodic(image, kPeriods);
  EXPECT_EQ(part.panels.at<unsigned char>(97, 3), 255);
  EXPECT_EQ(cv::countNonZero(part.marks), 0);
}

TEST(AperiodicPartTest, GrainIsLeftWithoutLines) {
  cv::Mat image = Tiles();
  cv::Mat grain(kTilesSize, CV_32FC1);
  cv::RNG(3).fill(grain, cv::RNG::NORMAL, 0, 2);
  image += grain;
  const AperiodicPart part = SplitAperiodic(image, kPeriods);
  // The median of seven copies, one of them the image itself, takes a part of it away.
  EXPECT_NEAR(part.deviation, 1.6, 0.15);
  EXPECT_TRUE(std::isnan(part.grain.at<float>(100, 3 * kTile)));
  EXPECT_NEAR(part.grain.at<float>(100, 140), grain.at<float>(100, 140), 2);
}

TEST(AperiodicPartTest, ShiftsAsStated) {
  cv::Mat image(kTilesSize, CV_32FC1);
  cv::RNG(4).fill(image, cv::RNG::NORMAL, 0, 2);
  const cv::Mat shifted = ShiftedBy(image, {7, -3});
  EXPECT_FLOAT_EQ(shifted.at<float>(50, 60), image.at<float>(47, 67));
  EXPECT_TRUE(std::isnan(shifted.at<float>(1, 60)));
  EXPECT_TRUE(std::isnan(shifted.at<float>(50, 316)));
}

TEST(AperiodicPartTest, TypicalDeviationOfKnownValues) {
  constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();
  const cv::Mat values = (cv::Mat_<float>(1, 4) << 1, -2, kNothing, 30);
  EXPECT_FLOAT_EQ(TypicalDeviation(values), 1.4826F * 2);
  EXPECT_TRUE(std::isnan(TypicalDeviation(values(cv::Rect(2, 0, 1, 1)))));
}

}  // namespace
}  // namespace ceilmap::registration
