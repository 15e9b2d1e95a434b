#include "mapping/registration/level_frame.hpp"

#include <gtest/gtest.h>

#include "mapping/registration/noise.hpp"

namespace ceilmap::registration {
namespace {

const ImageMotion kMotion{13.7, -41.2, 0.2, 1.1};

TEST(FineFactor, KeepsBlocksWithinTheirBounds) {
  EXPECT_EQ(FineFactor({640, 480}), 1);
  EXPECT_EQ(FineFactor({1200, 900}), 1);
  EXPECT_EQ(FineFactor({1201, 900}), 2);
  EXPECT_EQ(FineFactor({900, 2401}), 3);
  EXPECT_EQ(FineFactor({640, 239}), 0.5);
  EXPECT_EQ(FineFactor({240, 240}), 1);
}

TEST(LevelFrame, PixelsThatDoNotFillTheLevelAreCutOff) {
  const LevelFrame frame({645, 482}, 4);
  EXPECT_EQ(frame.size, cv::Size(161, 120));
  // The level shows the first 644 x 480 pixels: its centre is half a pixel left of that of the
  // image, and one above.
  EXPECT_EQ(frame.offset, Eigen::Vector2d(-0.5, -1));
  EXPECT_EQ(LevelFrame({200, 150}, 0.5).size, cv::Size(400, 300));
  EXPECT_EQ(LevelFrame({200, 150}, 0.5).offset, Eigen::Vector2d(0, 0));
}

TEST(LevelFrame, MotionsMoveTheSamePoints) {
  for (const double factor : {0.5, 1.0, 2.0, 4.0}) {
    const LevelFrame frame({645, 483}, factor);
    const ImageMotion level = frame.FromFull(kMotion);
    for (const Eigen::Vector2d& x : {Eigen::Vector2d(0, 0), {-70, 20}, {33, 50}}) {
      const Eigen::Vector2d there = kMotion.Apply(factor * x + frame.offset);
      EXPECT_LT((factor * level.Apply(x) + frame.offset - there).norm(), 1e-9) << factor;
    }
    const ImageMotion back = frame.ToFull(level);
    EXPECT_NEAR(back.tx_px, kMotion.tx_px, 1e-9);
    EXPECT_NEAR(back.ty_px, kMotion.ty_px, 1e-9);
    EXPECT_EQ(back.theta_rad, kMotion.theta_rad);
    EXPECT_EQ(back.scale, kMotion.scale);
  }
}

TEST(LevelFrame, ACameraSeesTheSameRays) {
  const LevelFrame frame({645, 483}, 2);
  const PlaneCamera full{400, {10, -7}};
  const PlaneCamera level = frame.CameraOf(full);
  const Eigen::Vector2d x(31, -12);
  const Eigen::Vector2d ray = (2 * x + frame.offset - full.principal_px) / full.focal_px;
  EXPECT_LT(((x - level.principal_px) / level.focal_px - ray).norm(), 1e-12);
}

TEST(LevelMask, APixelHasContentIfAllOfItsPixelsDo) {
  EXPECT_TRUE(LevelMask({}, {4, 3}).empty());
  cv::Mat mask(6, 8, CV_8UC1, cv::Scalar(255));
  mask.at<unsigned char>(3, 5) = 0;
  const cv::Mat level = LevelMask(mask, {4, 3});
  ASSERT_EQ(level.size(), cv::Size(4, 3));
  EXPECT_EQ(cv::countNonZero(level == 255), 11);
  EXPECT_LT(level.at<unsigned char>(1, 2), 255);
}

TEST(FillLevel, ReducesByMeansAndTheNoiseWithThem) {
  cv::Mat image(40, 64, CV_8UC1);
  cv::RNG rng(3);
  rng.fill(image, cv::RNG::UNIFORM, 0, 256);
  const ImageNoise noise = MakeNoise(4);
  Level level;
  FillLevel(image, 2, {32, 20}, noise, level);
  ASSERT_EQ(level.grey.size(), 32U * 20);
  const cv::Rect block(2 * 7, 2 * 5, 2, 2);
  EXPECT_NEAR(level.grey.data()[5 * 32 + 7], cv::mean(image(block))[0], 1e-3);
  EXPECT_LT(level.noise.white, noise.white);
}

}  // namespace
}  // namespace ceilmap::registration
