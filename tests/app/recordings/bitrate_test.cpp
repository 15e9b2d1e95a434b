#include "app/recordings/bitrate.hpp"

#include <gtest/gtest.h>

namespace ceilmap::recordings {
namespace {

constexpr double kPeriodS = 0.1;  // 30 images in the window of 3 s
const cv::Size kVideoSize(100, 10);

TEST(PixelRate, IsTheMeanOfTheLastSeconds) {
  PixelRate rate(kPeriodS, kVideoSize);
  EXPECT_EQ(rate.BitsPerSecond(), 0) << "nothing is known yet";
  rate.Add(500);
  EXPECT_DOUBLE_EQ(rate.BitsPerSecond(), 8 * 500 / 1000.0 / kPeriodS);
  for (int i = 0; i < 29; ++i) rate.Add(0);
  EXPECT_DOUBLE_EQ(rate.BitsPerSecond(), 8 * 500 / 1000.0 / 3) << "spent on all of them";
  rate.Add(25);
  EXPECT_DOUBLE_EQ(rate.BitsPerSecond(), 8 * 25 / 1000.0 / 3) << "the first one is too old";
}

TEST(PixelRate, IsTheSameForAnyRateOfImages) {
  PixelRate slow(0.1, kVideoSize);
  PixelRate fast(1 / 60.0, kVideoSize);
  for (int i = 0; i < 100; ++i) slow.Add(60);
  for (int i = 0; i < 600; ++i) fast.Add(10);
  EXPECT_NEAR(fast.BitsPerSecond(), slow.BitsPerSecond(), 1e-9);
}

TEST(PixelRate, IsUnknownWithoutThePeriod) {
  PixelRate rate(std::nullopt, kVideoSize);
  rate.Add(500);
  EXPECT_EQ(rate.BitsPerSecond(), 0);
}

}  // namespace
}  // namespace ceilmap::recordings
