#include "localization/compass/sector_shifts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tests/localization/compass/panoramas.hpp"

namespace ceilmap::compass {
namespace {

constexpr int kColumns = 720;
constexpr int kRows = 12;
constexpr double kColumnRad = 2 * std::numbers::pi / kColumns;

/// Fine texture of this contrast on a broad pattern that fades twice around the circle.
cv::Mat View(double contrast, double broad, int shift) {
  cv::Mat texture = RandomPanorama(kRows, kColumns, CV_8UC1, 1);
  cv::GaussianBlur(texture, texture, {5, 1}, 1.2, 0);
  const cv::Mat moved = Rolled(texture, shift);
  cv::Mat view(kRows, kColumns, CV_8UC1);
  for (int v = 0; v < kRows; ++v) {
    for (int u = 0; u < kColumns; ++u) {
      const double fades = std::sin(2 * kColumnRad * u + v);
      view.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(
          128 + broad * fades + contrast * (moved.at<std::uint8_t>(v, u) - 128));
    }
  }
  return view;
}

TEST(SectorMatcher, MeasuresTheShiftOfEachSector) {
  SectorMatcher matcher({kColumns, kRows}, 1);
  PanoramaLines before;
  PanoramaLines after;
  matcher.Analyze(View(0.5, 0, 0), before);
  for (const int shift : {-9, 0, 4}) {
    matcher.Analyze(View(0.5, 0, shift), after);
    const auto shifts = matcher.Measure(before, after, 0);
    EXPECT_GE(shifts.size(), 35U);
    for (const SectorShift& sector : shifts) {
      EXPECT_NEAR(sector.shift_rad, shift * kColumnRad, 0.1 * kColumnRad);
    }
  }
}

// The edge of a wall along the way stays in place while the faint texture of the wall moves.
TEST(SectorMatcher, WhatFadesBroadlyTellsNoMotion) {
  SectorMatcher matcher({kColumns, kRows}, 1);
  PanoramaLines before;
  PanoramaLines after;
  matcher.Analyze(View(0.1, 80, 0), before);
  matcher.Analyze(View(0.1, 80, 6), after);
  const auto shifts = matcher.Measure(before, after, 0);
  EXPECT_GE(shifts.size(), 30U);
  for (const SectorShift& sector : shifts) {
    EXPECT_NEAR(sector.shift_rad, 6 * kColumnRad, 0.5 * kColumnRad) << sector.azimuth_rad;
  }
}

// Between the sectors' centres there is a stripe of texture each, and nothing else.
TEST(SectorMatcher, TheAzimuthIsThatOfTheContent) {
  constexpr int kSpacing = kColumns / SectorMatcher::kSectors;
  constexpr int kFirst = 13;  // of a stripe, 6 columns right of a centre
  constexpr int kLast = 18;
  SectorMatcher matcher({kColumns, kRows}, 1);
  PanoramaLines before;
  PanoramaLines after;
  cv::Mat view = View(0.5, 0, 0);
  for (int u = 0; u < kColumns; ++u) {
    if (u % kSpacing < kFirst || u % kSpacing > kLast) view.col(u) = 128;
  }
  matcher.Analyze(Rolled(view, -2), before);
  matcher.Analyze(view, after);
  const auto shifts = matcher.Measure(before, after, 0);
  EXPECT_GE(shifts.size(), 30U);
  for (const SectorShift& sector : shifts) {
    const double column = (std::numbers::pi - sector.azimuth_rad) / kColumnRad;
    EXPECT_NEAR(std::fmod(column + kColumns, kSpacing), 0.5 * (kFirst + kLast), 2.5) << column;
  }
}

// In the dark there is noise only. Its least distance is where the reference is bare.
TEST(SectorMatcher, NoiseMatchesNothing) {
  SectorMatcher matcher({kColumns, kRows}, 1);
  PanoramaLines seen;
  PanoramaLines dark;
  cv::Mat patches = View(0.5, 0, 0);
  for (int u = 0; u < kColumns; ++u) {
    if (u / 12 % 2 == 0) patches.col(u) = 128;  // bare and textured in turn
  }
  matcher.Analyze(patches, seen);
  matcher.Analyze(RandomPanorama(kRows, kColumns, CV_8UC1, 9) / 64 + 8, dark);
  EXPECT_LE(matcher.Measure(seen, dark, 0).size(), 2U);
  EXPECT_LE(matcher.Measure(dark, seen, 0).size(), 2U);
  EXPECT_GE(matcher.Measure(seen, seen, 0).size(), 35U);
}

}  // namespace
}  // namespace ceilmap::compass
