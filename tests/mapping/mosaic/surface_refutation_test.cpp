#include "mapping/mosaic/surface_refutation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mapping/mosaic/height_map.hpp"
#include "tests/mapping/mosaic/two_planes.hpp"

namespace ceilmap::mosaic {
namespace {

using two_planes::Drive;

/// Sets the cells of a keyframe that show the surroundings of a place at a ratio.
void SetAround(const cv::Point2d& place,
               float shown_at,
               const heights::HeightCell& value,
               Drive& drive,
               std::size_t k,
               double radius = 0.15) {
  auto field = std::make_shared<heights::HeightField>(*drive.keyframes[k].heights);
  for (std::size_t i = 0; i < field->cells.size(); ++i) {
    const Eigen::Vector2d at = field->Centre(i);
    const cv::Point2d there = drive.views[k].ToMap(79.5 + at.x(), 59.5 + at.y(), shown_at);
    if (cv::norm(there - place) < radius) field->cells[i] = value;
  }
  drive.keyframes[k].heights = field;
}

const cv::Point2d kOnDeck(-0.35, 0);

TEST(SurfaceRefutation, ASurfaceThatOthersSeeThroughIsNone) {
  Drive drive = two_planes::Rows();
  // Two of the keyframes around the place measured something there, as below a fan.
  for (const std::size_t k : {0, 4}) SetAround(kOnDeck, 1.6F, {1.6F, 0.01F}, drive, k);
  EXPECT_FLOAT_EQ(HeightMap(drive.keyframes, drive.metadata).RatioAt(kOnDeck.x, kOnDeck.y), 1);
}

/// Twelve keyframes near each other. Only one of them has heights around kOnDeck, wrong ones.
Drive WithOneOpinion(double radius = 0.15) {
  std::vector<Pose2> poses;
  for (int i = 0; i < 12; ++i) poses.push_back({-0.4 + 0.02 * i, 0.03 * (i % 3), 0.1 * i});
  Drive drive(poses);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    SetAround(kOnDeck, 1, heights::kUnknown, drive, k, radius);
  }
  SetAround(kOnDeck, 1.3F, {1.3F, 0.01F}, drive, 0, radius);
  return drive;
}

TEST(SurfaceRefutation, ASurfaceOnWhichImagesDisagreeTakesTheHeightAroundIt) {
  const Drive drive = WithOneOpinion();
  HeightMap map(drive.keyframes, drive.metadata);
  ASSERT_FLOAT_EQ(map.RatioAt(kOnDeck.x, kOnDeck.y), 1.3F);
  const auto moves = [](const cv::Point2d& p_map, float /*rho*/) {
    return cv::norm(p_map - kOnDeck) < 0.2 ? 0.5 : 1.0;
  };
  const std::vector<cv::Point2d> moving = map.Settle(drive.keyframes, drive.metadata, moves);
  EXPECT_FLOAT_EQ(map.RatioAt(kOnDeck.x, kOnDeck.y), 1);
  ASSERT_FALSE(moving.empty());
  for (const cv::Point2d& place : moving) EXPECT_LT(cv::norm(place - kOnDeck), 0.4);
}

TEST(SurfaceRefutation, WhatASurfaceExplainsDoesNotMove) {
  const Drive drive = WithOneOpinion();
  HeightMap map(drive.keyframes, drive.metadata);
  const auto deck = [](const cv::Point2d& /*p_map*/, float rho) { return rho < 1.1F ? 1.0 : 0.5; };
  EXPECT_TRUE(map.Settle(drive.keyframes, drive.metadata, deck).empty());
  EXPECT_FLOAT_EQ(map.RatioAt(kOnDeck.x, kOnDeck.y), 1);
}

TEST(SurfaceRefutation, ASurfaceOnWhichImagesAgreeStays) {
  const Drive drive = WithOneOpinion();
  HeightMap map(drive.keyframes, drive.metadata);
  const auto agree = [](const cv::Point2d& /*p_map*/, float /*rho*/) { return 0.9; };
  EXPECT_TRUE(map.Settle(drive.keyframes, drive.metadata, agree).empty());
  EXPECT_FLOAT_EQ(map.RatioAt(kOnDeck.x, kOnDeck.y), 1.3F);
}

/// A raster of 96 x 96 pixels from (-32, -32) on, of what `ratio` states for each of them.
template <typename Ratio>
RatioRaster RasterOf(const store::MosaicGrid& grid, const Ratio& ratio) {
  RatioRaster raster(grid);
  raster.AddAround(0, 0);
  return raster.Transformed(1, [&](const cv::Rect& window, const cv::Mat_<float>& /*ratios*/) {
    cv::Mat_<float> result(window.size());
    for (int row = 0; row < window.height; ++row) {
      for (int col = 0; col < window.width; ++col) {
        result(row, col) = ratio(window.x + col, window.y + row);
      }
    }
    return result;
  });
}

TEST(FillGaps, ASurfaceReachesFivePixelsIntoTheUnknown) {
  const RatioRaster filled =
      FillGaps(RasterOf({}, [](int col, int /*row*/) { return col <= 0 ? 1.2F : 0.0F; }), 1);
  EXPECT_EQ(filled.At(-1, 3), 1.2F);
  EXPECT_EQ(filled.At(kFillReach, 3), 1.2F);
  EXPECT_EQ(filled.At(kFillReach + 1, 3), 0);
}

TEST(FillGaps, TheFartherSurfaceFillsAGap) {
  const RatioRaster filled = FillGaps(RasterOf({},
                                               [](int col, int /*row*/) {
                                                 if (std::abs(col) < 3) return 0.0F;
                                                 return col < 0 ? 1.4F : 1.0F;
                                               }),
                                      1);
  for (const int col : {-1, 0, 2}) EXPECT_EQ(filled.At(col, 0), 1.0F) << col;
  EXPECT_EQ(filled.At(-3, 0), 1.4F);
}

TEST(FillGaps, RefutedSurfacesAreReplacedFromFartherAway) {
  const auto refuted_to = [](int reach) {
    return FillGaps(RasterOf({},
                             [reach](int col, int row) {
                               const bool inside = std::max(std::abs(col), std::abs(row)) < reach;
                               return inside ? -1.4F : 1.0F;
                             }),
                    1)
        .At(0, 0);
  };
  EXPECT_EQ(refuted_to(12), 1.0F);
  EXPECT_EQ(refuted_to(20), 1.4F) << "nothing is around it: restored";
}

TEST(SurfaceRefutation, OneThatAsManyConfirmAsSeeThroughStays) {
  // Four keyframes from the same place measured the deck, or something before it.
  const auto elected = [](int nearer) {
    Drive drive({{-0.4, 0, 0}, {-0.4, 0, 0}, {-0.4, 0, 0}, {-0.4, 0, 0}});
    for (int k = 0; k < nearer; ++k) {
      SetAround(kOnDeck, 1.3F, {1.3F, 0.01F}, drive, static_cast<std::size_t>(k));
    }
    const HeightMap map(drive.keyframes, drive.metadata);
    return map.RatioAt(kOnDeck.x, kOnDeck.y);
  };
  EXPECT_FLOAT_EQ(elected(1), 1);
  EXPECT_FLOAT_EQ(elected(2), 1.3F);
}

TEST(SurfaceRefutation, ABorderBesideACellConfirmsIt) {
  // All measured the same thing. For three of them its border is beside the cell of the place.
  const cv::Point2d beside = kOnDeck + cv::Point2d(0.14, 0);
  Drive drive({{-0.4, 0, 0}, {-0.4, 0, 0}, {-0.4, 0, 0}, {-0.4, 0, 0}});
  SetAround(kOnDeck, 1.3F, {1.3F, 0.01F}, drive, 0);
  for (const std::size_t k : {1, 2, 3}) SetAround(beside, 1.3F, {1.3F, 0.01F}, drive, k, 0.1);
  const HeightMap map(drive.keyframes, drive.metadata);
  EXPECT_FLOAT_EQ(map.RatioAt(kOnDeck.x, kOnDeck.y), 1.3F);
}

TEST(SettleSurfaces, FewImagesRefuteNothing) {
  Drive drive = WithOneOpinion();
  drive.keyframes.resize(7);
  HeightMap map(drive.keyframes, drive.metadata);
  const auto never = [](const cv::Point2d& /*p_map*/, float /*rho*/) { return 0.0; };
  EXPECT_TRUE(map.Settle(drive.keyframes, drive.metadata, never).empty());
  EXPECT_FLOAT_EQ(map.RatioAt(kOnDeck.x, kOnDeck.y), 1.3F);
}

TEST(SettleSurfaces, WhatKeyframesConfirmStays) {
  Drive drive = WithOneOpinion();
  SetAround(kOnDeck, 1.3F, {1.3F, 0.01F}, drive, 1);  // two of twelve: 17 %
  HeightMap map(drive.keyframes, drive.metadata);
  const auto never = [](const cv::Point2d& /*p_map*/, float /*rho*/) { return 0.0; };
  (void)map.Settle(drive.keyframes, drive.metadata, never);
  EXPECT_FLOAT_EQ(map.RatioAt(kOnDeck.x, kOnDeck.y), 1.3F);
}

TEST(SettleSurfaces, TheReplacementMustNotAgreeLess) {
  const Drive drive = WithOneOpinion();
  HeightMap map(drive.keyframes, drive.metadata);
  // Another surface explains the images; the deck does so less than what was measured.
  const auto other = [](const cv::Point2d& /*p_map*/, float rho) {
    if (rho > 1.29F) return 0.6;
    return rho > 1.1F ? 0.9 : 0.5;
  };
  EXPECT_TRUE(map.Settle(drive.keyframes, drive.metadata, other).empty());
  EXPECT_FLOAT_EQ(map.RatioAt(kOnDeck.x, kOnDeck.y), 1.3F);
}

TEST(SettleSurfaces, PartsOfAMovingThingGoWithIt) {
  // A quarter of the keyframes measured a part of the surface, as blades of a fan are measured.
  Drive drive = WithOneOpinion(0.3);
  for (const std::size_t k : {1, 2}) SetAround(kOnDeck, 1.3F, {1.3F, 0.01F}, drive, k, 0.05);
  HeightMap map(drive.keyframes, drive.metadata);
  HeightMap other = map;
  ASSERT_FLOAT_EQ(map.RatioAt(kOnDeck.x, kOnDeck.y), 1.3F);
  const auto moves = [](const cv::Point2d& p_map, float /*rho*/) {
    return cv::norm(p_map - kOnDeck) < 0.4 ? 0.5 : 1.0;
  };
  EXPECT_FALSE(map.Settle(drive.keyframes, drive.metadata, moves).empty());
  EXPECT_FLOAT_EQ(map.RatioAt(kOnDeck.x, kOnDeck.y), 1);
  // Where the images agree on a part of it, that part stays.
  const auto moves_around = [&](const cv::Point2d& p_map, float rho) {
    return cv::norm(p_map - kOnDeck) < 0.1 ? 1.0 : moves(p_map, rho);
  };
  EXPECT_FALSE(other.Settle(drive.keyframes, drive.metadata, moves_around).empty());
  EXPECT_FLOAT_EQ(other.RatioAt(kOnDeck.x, kOnDeck.y), 1.3F);
}

}  // namespace
}  // namespace ceilmap::mosaic
