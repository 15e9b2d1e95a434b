#include "localization/compass/labrosse/labrosse2004.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "calib/base/error.hpp"
#include "calib/base/pose2.hpp"
#include "localization/compass/labrosse/column_shift.hpp"
#include "tests/localization/compass/panoramas.hpp"

namespace ceilmap::labrosse {
namespace {

TEST(Labrosse2004, AddsUpTurns) {
  const cv::Mat world = compass::RandomPanorama(9, 360, CV_8UC3, 1);
  std::mt19937 random(2);
  Labrosse2004 compass;
  int heading = 0;
  double variance = -1;
  for (int i = 0; i < 40; ++i) {
    const auto estimate = compass.Next({compass::Rolled(world, heading), 0.1 * i});
    ASSERT_TRUE(estimate.has_value());
    EXPECT_NEAR(WrapAngle(estimate->heading_rad - heading * kRadPerDeg), 0, 1e-9);
    EXPECT_LE(estimate->heading_rad, std::numbers::pi);
    EXPECT_GT(estimate->heading_rad, -std::numbers::pi - 1e-12);
    EXPECT_GT(estimate->variance_rad2, variance);
    EXPECT_EQ(estimate->confidence, 1);
    variance = estimate->variance_rad2;
    heading += static_cast<int>(random() % 360);
  }
  EXPECT_EQ(compass.References(), 40);
}

TEST(Labrosse2004, MeasuresNoTurnOfLessThanHalfAColumn) {
  const compass::Waves world(6, 90, CV_8UC1, 3);
  Labrosse2004 compass;
  for (int i = 0; i < 10; ++i) {
    const auto estimate = compass.Next({world.At(0.4 * 4 * kRadPerDeg * i), 0.1 * i});
    EXPECT_EQ(estimate->heading_rad, 0);
    // Which is what it takes for the error of a rounded column.
    if (i > 0) {
      EXPECT_NEAR(
          std::sqrt(estimate->variance_rad2), i * std::sqrt(1.0 / 12) * 4 * kRadPerDeg, 0.01 * i);
    }
  }
}

TEST(Labrosse2004, HoldsTheHeadingWithoutTexture) {
  const cv::Mat world = compass::RandomPanorama(9, 360, CV_8UC3, 4);
  const cv::Mat grey(9, 360, CV_8UC3, cv::Scalar(40, 90, 90));
  cv::Mat noise = compass::RandomPanorama(9, 360, CV_8UC3, 5) / 128 + grey;  // one grey level
  const cv::Mat periodic = cv::repeat(compass::RandomPanorama(9, 90, CV_8UC3, 6), 1, 4);
  Labrosse2004 compass;
  double stamp = 10;
  EXPECT_EQ(compass.Next({grey, stamp})->confidence, 0);
  EXPECT_EQ(compass.Next({noise, ++stamp})->heading_rad, 0);
  EXPECT_GT(compass.Next({world, ++stamp})->variance_rad2, 0);
  double variance = compass.Next({compass::Rolled(world, 7), ++stamp})->variance_rad2;
  const double seen = variance;
  for (const cv::Mat& blind : {grey, noise, grey}) {
    const auto held = compass.Next({blind, ++stamp});
    EXPECT_NEAR(held->heading_rad, 7 * kRadPerDeg, 1e-9);
    EXPECT_EQ(held->confidence, 0);
    EXPECT_GT(held->variance_rad2, variance);
    variance = held->variance_rad2;
  }
  // Compared with the last valid panorama, the turn is measured and the variance is small again.
  const auto again = compass.Next({compass::Rolled(world, 50), ++stamp});
  EXPECT_NEAR(again->heading_rad, 50 * kRadPerDeg, 1e-9);
  EXPECT_EQ(again->confidence, 1);
  EXPECT_LT(again->variance_rad2, 2 * seen);
  (void)compass.Next({periodic, ++stamp});
  EXPECT_EQ(compass.Next({periodic, ++stamp})->confidence, 0);
}

TEST(Labrosse2004, ShowsItsDistances) {
  const cv::Mat world = compass::RandomPanorama(5, 36, CV_8UC1, 7);
  Labrosse2004 compass;
  (void)compass.Next({world, 0});
  EXPECT_TRUE(compass.Profile().distance.empty());
  const cv::Mat turned =
      0.5 * compass::Rolled(world, -18) + 0.5 * compass::RandomPanorama(5, 36, CV_8UC1, 8);
  (void)compass.Next({turned, 1});
  const compass::DistanceProfile profile = compass.Profile();
  const auto squared = SquaredShiftDistances(world, turned);
  ASSERT_EQ(profile.distance.size(), 36U);
  for (std::size_t s = 0; s < 36; ++s) {
    EXPECT_DOUBLE_EQ(profile.distance[s] * profile.distance[s], static_cast<double>(squared[s]));
  }
  EXPECT_EQ(profile.shift_columns, -18);
  EXPECT_EQ(profile.reference_frame, 0);
}

std::string ErrorOf(compass::Compass& compass, const compass::PanoramaFrame& frame) {
  try {
    (void)compass.Next(frame);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Labrosse2004, RefusesFramesThatDoNotFitTheRun) {
  Labrosse2004 compass;
  EXPECT_EQ(ErrorOf(compass, {compass::RandomPanorama(5, 7, CV_8UC1, 1), 0}),
            "a panorama of 7 columns is too narrow for a compass, must have at least 8; unwrap it "
            "to more columns");
  EXPECT_EQ(ErrorOf(compass, {cv::Mat(), 0}),
            "the panorama is 0 x 0 pixels, must have 2 to 16384 columns and at least 1 row; unwrap "
            "it with other settings");
  const cv::Mat good = compass::RandomPanorama(5, 36, CV_8UC1, 1);
  EXPECT_EQ(ErrorOf(compass, {good, 1.5}), "no error");
  EXPECT_EQ(ErrorOf(compass, {good, 1.5}),
            "panorama 1: time 1.5 s is not later than the one before");
  EXPECT_EQ(ErrorOf(compass, {compass::RandomPanorama(5, 36, CV_8UC3, 1), 2}),
            "panorama 1 is 36 x 5 CV_8UC3, those before are 36 x 5 CV_8UC1; unwrap all with the "
            "same settings");
  EXPECT_EQ(ErrorOf(compass, {good, 2, Eigen::Vector2d(1, std::nan(""))}),
            "panorama 1: travel (1, nan), must be finite");
  EXPECT_EQ(ErrorOf(compass, {good, 2}), "no error");
}

}  // namespace
}  // namespace ceilmap::labrosse
