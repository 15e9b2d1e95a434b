#include "mapping/change/light_looks.hpp"

#include <gtest/gtest.h>

#include "tests/mapping/change/looks.hpp"

namespace ceilmap::change {
namespace {

using namespace synthetic;
using store::Look;

const cv::Rect kSeenByNight{5, 5, 20, 20};
const cv::Rect kLampCells{14, 9, 4, 3};  // on the border of two looks
const cv::Rect kOtherLampCells{20, 20, 2, 2};

/// Evidence of a recording in which two places look otherwise.
ChangeEvidence SeenAs(CellState state, const cv::Rect& place = kLampCells) {
  ChangeEvidence evidence(kAll);
  if (state == CellState::kLamp) {
    ViewComparison dark = SameView({30, 30, 1, 1});
    dark.lamps_differ = 100;
    evidence.Add(dark);
  }
  AddChangedViews(evidence, kSeenByNight, place, state, 3);
  return evidence;
}

std::vector<Look> UpdatedBy(const std::vector<Look>& looks,
                            const ChangeEvidence& evidence,
                            const std::vector<cv::Point>& fresh = {}) {
  return UpdateLooks(looks, evidence, FindChanges(evidence), fresh, 7);
}

/// Pixels of all looks that differ from the mosaic.
int PixelsDrawn(const std::vector<Look>& looks) {
  int pixels = 0;
  for (const Look& look : looks) pixels += cv::countNonZero(look.image);
  return pixels;
}

TEST(LightLooks, LampsInAnotherLightAreKept) {
  const ChangeEvidence night = SeenAs(CellState::kLamp);
  ASSERT_TRUE(night.OtherLight());
  const std::vector<Look> looks = UpdatedBy({}, night);
  ASSERT_EQ(looks.size(), 2U);
  EXPECT_EQ(looks[0].id, 1);
  EXPECT_EQ(looks[0].session, 7);
  EXPECT_EQ(looks[0].origin_px, cv::Point(0, 0));
  EXPECT_EQ(looks[1].origin_px, cv::Point(Look::kSizePx, 0));
  EXPECT_EQ(PixelsDrawn(looks), kLampCells.area() * kCellPx * kCellPx);
  const cv::Point cell(14, 10);
  const cv::Mat drawn = looks[0].image(cv::Rect(cell * kCellPx, cv::Size(kCellPx, kCellPx)));
  EXPECT_EQ(cv::norm(drawn, night.At(cell)->looks[0].Mean(), cv::NORM_INF), 0);
}

TEST(LightLooks, AChangeInTheLightOfTheMapKeepsNone) {
  EXPECT_TRUE(UpdatedBy({}, SeenAs(CellState::kTexture)).empty());
}

TEST(LightLooks, WhatWasRenewedIsErased) {
  const std::vector<Look> looks = UpdatedBy({}, SeenAs(CellState::kLamp));
  const std::vector<Look> left = UpdatedBy(looks, SeenAs(CellState::kTexture), {{14, 9}, {15, 9}});
  EXPECT_EQ(PixelsDrawn(looks) - PixelsDrawn(left), 2 * kCellPx * kCellPx);
}

TEST(LightLooks, ALampThatLooksAsInTheMapIsErased) {
  const std::vector<Look> looks = UpdatedBy({}, SeenAs(CellState::kLamp));
  const std::vector<Look> moved = UpdatedBy(looks, SeenAs(CellState::kLamp, kOtherLampCells));
  ASSERT_EQ(moved.size(), 1U);
  EXPECT_EQ(moved[0].origin_px, cv::Point(Look::kSizePx, Look::kSizePx));
  EXPECT_EQ(PixelsDrawn(moved), kOtherLampCells.area() * kCellPx * kCellPx);
}

TEST(LightLooks, RecordingsInOneLightDoNotAddUp) {
  std::vector<Look> looks = UpdatedBy({}, SeenAs(CellState::kLamp));
  const int once = PixelsDrawn(looks);
  for (int i = 0; i < 3; ++i) looks = UpdatedBy(looks, SeenAs(CellState::kLamp));
  EXPECT_EQ(PixelsDrawn(looks), once);
}

}  // namespace
}  // namespace ceilmap::change
